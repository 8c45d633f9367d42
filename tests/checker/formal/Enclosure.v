(* Theorem 1 for polynomials in one bicycle: what a motion is, the checks, and why they suffice. *)
From Coq Require Import Reals ZArith List Bool Lra Lia.
From Coquelicot Require Import Coquelicot.
From Interval Require Import Xreal Interval.Interval Float_full Tactic_float.
From Interval Require Import Eval.Tree Eval.Prog Eval.Eval.
Require Import Growth Sums Slopes.
Import ListNotations.
Open Scope R_scope.

Module TV := A.TaylorValuator.
Module TM := TV.TM.

Definition count := 7%nat. (* of state variables *)

(* n over 2 to the power of bits *)
Definition over (n : Z) (bits : Z) : R := IZR n / IZR (2 ^ bits).

(* Coefficients are integers over 2^52, by variable, the constant one first; the growth rate is one over
   2^4, and the rest, over 2^160, are bounds of sums of squares: of defect, of the error at both ends. *)
Record piece := Piece {
  coefficients : list (list Z); growth : Z; defect : Z; entry : Z; exit : Z }.

Fixpoint polynomial (c : list Z) (s : R) : R :=
  match c with nil => 0 | a :: c => over a 52 + s * polynomial c s end.
Fixpoint slope_of (c : list Z) (s : R) : R :=
  match c with nil => 0 | a :: c => polynomial c s + s * slope_of c s end.
Definition candidate (p : piece) (i : nat) := polynomial (nth i (coefficients p) nil).

Definition step : R := 1 / 32.
(* Weights of the variables' errors, in 12ths. *)
Definition weights : list Z := [12; 1; 4; 36; 72; 144; 192]%Z.
Definition weight (i : nat) : R := IZR (nth i weights 1%Z) / 12.
(* Balances the rows of a matrix, see Sums.v. *)
Definition balances : list Z := [60; 20; 96; 100; 38; 20; 6]%Z.
Definition balance (i : nat) : R := IZR (nth i balances 1%Z).
Definition tube : Z := 2 ^ 112. (* over 2^160: errors stay below 2^-24 times their weights *)
Definition error : R := 1 / 100000000.

Section Enclosure.
Variable program : list term.
Variable integers : list Z.
Variable start : list (Z * Z).

Definition constants : list R := map IZR integers ++ [PI].

(* The right-hand side of the equations of motion. *)
Definition field (i : nat) (x : list R) : R := nth i (eval_real program (x ++ constants)) 0.

Definition state (x : nat -> R -> R) (t : R) : list R := map (fun i => x i t) (seq 0 count).

Definition motion (x : nat -> R -> R) (until : R) : Prop :=
  forall t, 0 <= t <= until -> forall i, (i < count)%nat ->
  is_derive (x i) t (field i (state x t)).

Definition begins (x : nat -> R -> R) : Prop :=
  forall i, (i < count)%nat -> x i 0 = let (a, b) := nth i start (0, 1)%Z in IZR a / IZR b.

(* The conclusion of Theorem 1. *)
Definition near_candidate (x : nat -> R -> R) (until : R) (pieces : list piece) : Prop :=
  forall k p, nth_error pieces k = Some p ->
  forall s, 0 <= s <= step -> INR k * step + s <= until ->
  forall i, (i < count)%nat -> Rabs (x i (INR k * step + s) - candidate p i s) <= error.

(* The checks, in intervals of binary64. *)

Definition scaled (n bits : Z) : I.type := I.div prec (integer n) (integer (2 ^ bits)).
Definition step_in : I.type := I.div prec (integer 1) (integer 32).
Definition weight_in (i : nat) : I.type :=
  I.div prec (integer (nth i weights 1%Z)) (integer 12).
Definition balance_in (i : nat) : I.type := integer (nth i balances 1%Z).
Definition span : I.type := I.join I.zero step_in.
Definition symmetric (a : I.type) : I.type := I.join (I.neg a) a.
Definition square_in (a : I.type) : I.type := I.mul prec a a.
Definition constants_in : list I.type := map integer integers ++ [I.pi prec].

Definition degree := 16%nat.
Definition u : TM.U := (prec, degree).

Fixpoint models (c : list Z) : TM.T * TM.T :=
  match c with
  | nil => (TM.const I.zero, TM.const I.zero)
  | a :: c => let (p, d) := models c in
    (TM.add u span (TM.const (scaled a 52)) (TM.mul u span TM.var p),
     TM.add u span p (TM.mul u span TM.var d))
  end.

Fixpoint value_in (c : list Z) (s : I.type) : I.type :=
  match c with nil => I.zero | a :: c => I.add prec (scaled a 52) (I.mul prec s (value_in c s)) end.

Definition unit_slopes (i : nat) : list I.type := repeat I.zero i ++ [integer 1].

Definition all_states (f : nat -> bool) : bool := forallb f (seq 0 count).

(* w_j / w_i times slope, and the entries of twice the symmetric part *)
Definition weighted (slopes : nat -> nat -> I.type) i j : I.type :=
  I.div prec (I.mul prec (slopes i j) (weight_in j)) (weight_in i).
Definition twice_part_in (b : nat -> nat -> I.type) i j : I.type :=
  if Nat.eqb i j then I.mul prec (integer 2) (b i i) else I.abs (I.add prec (b i j) (b j i)).

Definition has_slopes (a : sloped) : bool := match a with Some _ => true | None => false end.
Definition slopes_of (a : sloped) (j : nat) : I.type :=
  match a with Some (_, p) => nth j p I.zero | None => I.zero end.

Definition models_of (p : piece) (i : nat) := models (nth i (coefficients p) nil).

(* The rates along the candidate, and how far its derivative is from them. *)
Definition rates_of (p : piece) : list TM.T :=
  eval_generic TM.dummy (TV.operations prec degree span) program
    (map (fun i => fst (models_of p i)) (seq 0 count) ++ map TM.const constants_in).
Definition missing (p : piece) (rates : list TM.T) (i : nat) : I.type :=
  TM.eval u (TM.sub u span (snd (models_of p i)) (nth i rates TM.dummy)) span span.

(* All states in the tube around the candidate, and the slopes of the rates over them. *)
Definition room (i : nat) : I.type := symmetric (I.div prec (weight_in i) (integer (2 ^ 24))).
Definition box (p : piece) (i : nat) : I.type :=
  I.add prec (TM.eval u (fst (models_of p i)) span span) (room i).
Definition slopes_found (p : piece) : list sloped :=
  eval_generic None sloped_operations program
    (map (fun i => Some (box p i, unit_slopes i)) (seq 0 count)
     ++ map (fun c => Some (c, nil)) constants_in).

Definition check_piece (p : piece) : bool :=
  let rates := rates_of p in
  let found := slopes_found p in
  let rate := scaled (growth p) 4 in
  let slopes i := slopes_of (nth i found None) in
  all_states (fun i => has_slopes (nth i found None))
  && all_states (fun i => is_positive (I.sub prec (I.sub prec rate (integer 1))
       (interval_sum count (fun j =>
          I.mul prec (twice_part_in (weighted slopes) i j) (I.div prec (balance_in j) (balance_in i))))))
  && is_positive (I.sub prec (scaled (defect p) 160)
       (interval_sum count (fun i => square_in (I.div prec (missing p rates i) (weight_in i)))))
  && Z.leb 0 (growth p)
  && is_positive (I.sub prec (scaled (exit p) 160)
       (I.mul prec (I.add prec (scaled (entry p) 160) (I.mul prec (scaled (defect p) 160) step_in))
          (I.exp prec (I.mul prec rate step_in))))
  && Z.ltb (exit p) tube
  && all_states (fun i => is_positive (I.sub prec (square_in (I.div prec (integer 1) (integer 100000000)))
       (I.mul prec (square_in (weight_in i)) (scaled (exit p) 160)))).

(* The error at the end of p with the jump to q, in squares, is at most what q may begin with. *)
Definition check_jump (p q : piece) : bool :=
  let jump i := I.sub prec (value_in (nth i (coefficients p) nil) step_in)
                  (value_in (nth i (coefficients q) nil) I.zero) in
  is_positive (I.sub prec (scaled (entry q) 160)
    (I.add prec (I.mul prec (scaled 1025 10) (scaled (exit p) 160))
       (I.mul prec (integer 1025)
          (interval_sum count (fun i => square_in (I.div prec (jump i) (weight_in i))))))).

Definition check_start (p : piece) : bool :=
  let distance i :=
    I.sub prec (let (a, b) := nth i start (0, 1)%Z in I.div prec (integer a) (integer b))
      (value_in (nth i (coefficients p) nil) I.zero) in
  all_states (fun i => Z.ltb 0 (snd (nth i start (0, 1)%Z)))
  && is_positive (I.sub prec (scaled (entry p) 160)
       (interval_sum count (fun i => square_in (I.div prec (distance i) (weight_in i))))).

Fixpoint check_chain (pieces : list piece) : bool :=
  match pieces with
  | nil => true
  | p :: rest =>
    check_piece p && match rest with nil => true | q :: _ => check_jump p q end && check_chain rest
  end.

Definition check (pieces : list piece) : bool :=
  match pieces with nil => true | p :: _ => check_start p end && check_chain pieces.

(* Why they suffice. *)

Lemma power_nonzero b : (0 <= b)%Z -> IZR (2 ^ b) <> 0.
Proof. intros H; apply IZR_neq, Z.pow_nonzero; lia. Qed.

Lemma scaled_in n b : (0 <= b)%Z -> over n b \in scaled n b.
Proof. intros H; apply div_in; [now apply power_nonzero | apply integer_in | apply integer_in]. Qed.

Lemma step_is_in : step \in step_in.
Proof. apply div_in; [lra | apply (integer_in 1) | apply (integer_in 32)]. Qed.

Lemma weight_is_in i : weight i \in weight_in i.
Proof. apply div_in; [lra | apply integer_in | apply (integer_in 12)]. Qed.

Lemma weight_positive i : 0 < weight i.
Proof. unfold weight, weights; do 7 (destruct i as [|i]; [simpl; lra|]); destruct i; simpl; lra. Qed.

Lemma balance_positive i : 0 < balance i.
Proof. unfold balance, balances; do 7 (destruct i as [|i]; [simpl; lra|]); destruct i; simpl; lra. Qed.

Lemma square_is_in x a : x \in a -> x * x \in square_in a.
Proof. intros X; now apply mul_in. Qed.

Lemma between_in a x y z : x \in a -> y \in a -> x <= z <= y -> z \in a.
Proof. intros X Y Z; exact (contains_connected (I.convert a) x y X Y z Z). Qed.

Lemma span_in s : 0 <= s <= step -> s \in span.
Proof.
intros H; apply between_in with 0 step; [| |easy]; apply I.join_correct.
- left; apply zero_in.
- right; apply step_is_in.
Qed.

Lemma symmetric_in x y a : y \in a -> Rabs x <= y -> x \in symmetric a.
Proof.
intros Y X; apply between_in with (- y) y; [| |now apply Rabs_le_between].
- apply I.join_correct; left; now apply neg_in.
- apply I.join_correct; now right.
Qed.

Lemma all_states_spec f i : all_states f = true -> (i < count)%nat -> f i = true.
Proof.
unfold all_states; rewrite forallb_forall; intros H Hi; apply H, in_seq; lia.
Qed.

Lemma constants_within : A.contains_all constants_in constants.
Proof.
unfold constants_in, constants; split.
  now rewrite !app_length, !map_length.
intros j; destruct (le_lt_dec (length (map integer integers)) j) as [H|H].
  rewrite app_nth2 by easy.
  rewrite app_nth2 by now rewrite map_length in *.
  rewrite !map_length in *.
  destruct (j - length integers)%nat as [|k]; [apply I.pi_correct|].
  now destruct k.
rewrite !app_nth1 by now rewrite map_length in *.
rewrite map_length in H.
rewrite (nth_indep _ I.nai (integer 0)) by now rewrite map_length.
rewrite !map_nth; apply integer_in.
Qed.

Lemma is_derive_polynomial c s : is_derive (polynomial c) s (slope_of c s).
Proof.
induction c as [|a c IH]; simpl; [exact (is_derive_const 0 s)|].
replace (polynomial c s + s * slope_of c s) with (0 + (1 * polynomial c s + s * slope_of c s)) by ring.
apply (is_derive_plus (fun _ => over a 52) (fun s => s * polynomial c s)).
  apply (is_derive_const (over a 52)).
apply (is_derive_mult (fun s => s) (polynomial c)); [apply (is_derive_id s) | exact IH | intros; apply Rmult_comm].
Qed.

Lemma models_correct c :
  TM.approximates span (fst (models c)) (fun s => Xreal (polynomial c s)) /\
  TM.approximates span (snd (models c)) (fun s => Xreal (slope_of c s)).
Proof.
induction c as [|a c [P D]]; cbn [models polynomial slope_of].
  split; apply TM.const_correct, zero_in.
destruct (models c) as [p d]; cbn [fst snd] in *; split.
- apply (@TM.add_correct u span _ _ (fun _ => Xreal (over a 52)) (fun s => Xreal (s * polynomial c s))).
    apply TM.const_correct, scaled_in; lia.
  now apply (@TM.mul_correct u span _ _ Xreal (fun s => Xreal (polynomial c s))); [apply TM.var_correct|].
- apply (@TM.add_correct u span _ _ (fun s => Xreal (polynomial c s)) (fun s => Xreal (s * slope_of c s))); [easy|].
  now apply (@TM.mul_correct u span _ _ Xreal (fun s => Xreal (slope_of c s))); [apply TM.var_correct|].
Qed.

Lemma value_is_in c s a : s \in a -> polynomial c s \in value_in c a.
Proof.
intros S; induction c as [|b c IH]; cbn [polynomial value_in]; [apply zero_in|].
apply add_in; [apply scaled_in; lia | now apply mul_in].
Qed.

Lemma models_of_program (inputs : R -> list ExtendedR) (tms : list TM.T) i :
  (forall j, TM.approximates span (nth j tms TM.dummy) (fun s => nth j (inputs s) Xnan)) ->
  TM.approximates span
    (nth i (eval_generic TM.dummy (TV.operations prec degree span) program tms) TM.dummy)
    (fun s => nth i (eval_ext program (inputs s)) Xnan).
Proof.
intros H; unfold eval_ext.
apply (eval_inductive_prop_fun ExtendedR TM.T (fun a b => TM.approximates span b a)); try easy.
- intros a b E t; apply TM.approximates_ext; now intros s; rewrite E.
- apply TM.dummy_correct.
- intros o a b T; destruct o; cbn [unary ext_operations TV.operations].
  + now apply TM.opp_correct.
  + now apply TM.abs_correct.
  + now apply TM.inv_correct.
  + now apply TM.sqr_correct.
  + now apply TM.sqrt_correct.
  + now apply TM.cos_correct.
  + now apply TM.sin_correct.
  + now apply TM.tan_correct.
  + now apply TM.atan_correct.
  + now apply TM.exp_correct.
  + now apply TM.ln_correct.
  + now apply TM.power_int_correct.
  + now apply TM.nearbyint_correct.
  + now apply TM.round_flt_correct.
- intros o a1 a2 b1 b2 T1 T2; destruct o; cbn [binary ext_operations TV.operations].
  + now apply TM.add_correct.
  + now apply TM.sub_correct.
  + now apply TM.mul_correct.
  + now apply TM.div_correct.
Qed.

Definition candidate_state (p : piece) (s : R) : list R := map (fun i => candidate p i s) (seq 0 count).

Lemma nth_state (f : nat -> R) (l : list R) j d :
  nth j (map f (seq 0 count) ++ l) d = if Nat.ltb j count then f j else nth (j - count) l d.
Proof.
destruct (Nat.ltb_spec j count) as [H|H].
  rewrite app_nth1 by now rewrite map_length, seq_length.
  rewrite (nth_indep _ d (f O)) by now rewrite map_length, seq_length.
  now rewrite map_nth, seq_nth.
now rewrite app_nth2, map_length, seq_length by now rewrite map_length, seq_length.
Qed.

Lemma missing_in p s i :
  0 <= s <= step ->
  slope_of (nth i (coefficients p) nil) s - field i (candidate_state p s) \in missing p (rates_of p) i.
Proof.
intros Hs; unfold field.
apply (xreal_to_real
  (fun y => contains (I.convert (missing p (rates_of p) i)) (Xsub (Xreal (slope_of (nth i (coefficients p) nil) s)) y))
  (fun r => slope_of (nth i (coefficients p) nil) s - r \in missing p (rates_of p) i)).
- simpl; intros H r; destruct (I.convert (missing p (rates_of p) i)); easy.
- now simpl.
- set (f := fun s => Xsub (Xreal (slope_of (nth i (coefficients p) nil) s))
      (nth i (eval_ext program (map Xreal (candidate_state p s ++ constants))) Xnan)).
  refine (@TM.eval_correct u span _ f _ span (Xreal s) (span_in s Hs)).
  apply (@TM.sub_correct u span _ _ (fun s => Xreal (slope_of (nth i (coefficients p) nil) s))
    (fun s => nth i (eval_ext program (map Xreal (candidate_state p s ++ constants))) Xnan)).
    apply models_correct.
  apply models_of_program; intros j.
  destruct (le_lt_dec count j) as [H|H].
  + rewrite app_nth2 by now rewrite map_length, seq_length.
    apply TM.approximates_ext with (fun _ => nth (j - count) (map Xreal constants) Xnan).
      intros t; rewrite map_app, app_nth2; unfold candidate_state; now rewrite !map_length, seq_length.
    rewrite map_length, seq_length.
    destruct constants_within as [L C].
    destruct (le_lt_dec (length constants_in) (j - count)) as [K|K].
      rewrite nth_overflow by (now rewrite map_length); apply TM.dummy_correct.
    rewrite (nth_indep _ TM.dummy (TM.const I.nai)) by now rewrite map_length.
    rewrite (nth_indep _ Xnan (Xreal 0)) by now rewrite map_length, <- L.
    rewrite !map_nth; now apply TM.const_correct.
  + rewrite app_nth1 by now rewrite map_length, seq_length.
    rewrite (nth_indep _ TM.dummy (fst (models_of p O))) by now rewrite map_length, seq_length.
    rewrite (map_nth (fun i => fst (models_of p i))), seq_nth by easy.
    apply TM.approximates_ext with (fun s => Xreal (candidate p j s)).
      intros t; rewrite (nth_indep _ Xnan (Xreal 0)).
        now rewrite map_nth; unfold candidate_state; rewrite nth_state; destruct (Nat.ltb_spec j count); [|lia].
      rewrite map_length, app_length; unfold candidate_state; rewrite map_length, seq_length; lia.
    apply models_correct.
Qed.

Lemma sum_unit n j (e : nat -> R) :
  (j < n)%nat -> sum n (fun k => (if Nat.eqb k j then 1 else 0) * e k) = e j.
Proof.
induction n as [|n IH]; intros H; [lia|]; simpl.
destruct (Nat.eqb_spec n j) as [->|N].
  rewrite (sum_ext j _ (fun k => 0 * e k)), sum_scal; [ring|].
  intros k K; destruct (Nat.eqb_spec k j); [lia | easy].
rewrite IH by lia; ring.
Qed.

Lemma unit_slopes_within j : within (fun k => if Nat.eqb k j then 1 else 0) (unit_slopes j).
Proof.
intros k; unfold unit_slopes.
destruct (Nat.eqb_spec k j) as [->|N].
  rewrite app_nth2; rewrite repeat_length; [|lia].
  rewrite Nat.sub_diag; apply (integer_in 1).
destruct (le_lt_dec j k) as [H|H].
  rewrite app_nth2; rewrite repeat_length; [|lia].
  destruct (k - j)%nat as [|m] eqn:E; [lia|]; destruct m; apply zero_in.
rewrite app_nth1 by now rewrite repeat_length.
rewrite nth_repeat; apply zero_in.
Qed.

Lemma room_in i r : Rabs r <= weight i / 2 ^ 24 -> r \in room i.
Proof.
intros H; apply symmetric_in with (weight i / 2 ^ 24); [|easy].
rewrite (pow_IZR 2 24).
apply div_in; [apply IZR_neq; lia | apply weight_is_in | apply integer_in].
Qed.

Lemma field_difference p s (e : nat -> R) i :
  0 <= s <= step ->
  (forall j, (j < count)%nat -> Rabs (e j) <= weight j / 2 ^ 24) ->
  has_slopes (nth i (slopes_found p) None) = true ->
  exists g, (forall j, g j \in slopes_of (nth i (slopes_found p) None) j) /\
    field i (map (fun j => candidate p j s + e j) (seq 0 count)) - field i (candidate_state p s)
    = sum count (fun j => g j * e j).
Proof.
intros Hs He Has.
set (inputs := fun r => map (fun j => candidate p j s + r * e j) (seq 0 count) ++ constants).
assert (M : moves count e (fun r => nth i (eval_real program (inputs r)) 0) (nth i (slopes_found p) None)).
  apply moves_program; intros j.
  destruct (le_lt_dec count j) as [H|H].
  - rewrite app_nth2 by now rewrite map_length, seq_length.
    rewrite map_length, seq_length.
    destruct constants_within as [L C].
    destruct (le_lt_dec (length constants_in) (j - count)) as [K|K].
      now rewrite nth_overflow by (now rewrite map_length).
    rewrite (nth_indep _ None (Some (I.nai, nil))) by now rewrite map_length.
    rewrite (map_nth (fun c => Some (c, nil))).
    intros r _; unfold inputs; rewrite nth_state.
    destruct (Nat.ltb_spec j count) as [|_]; [lia|]; split; [apply C|].
    exists (fun _ => 0); split; [intros k; destruct k; apply zero_in|].
    rewrite sum_scal, Rmult_0_l.
    apply (is_derive_ext (fun _ => nth (j - count) constants 0)); [|apply (is_derive_const (nth (j - count) constants 0))].
    intros t; rewrite nth_state; destruct (Nat.ltb_spec j count); [lia | easy].
  - rewrite app_nth1 by now rewrite map_length, seq_length.
    rewrite (nth_indep _ None (Some (box p O, unit_slopes O))) by now rewrite map_length, seq_length.
    rewrite (map_nth (fun i => Some (box p i, unit_slopes i))), seq_nth by easy.
    intros r Hr; unfold inputs; rewrite nth_state.
    destruct (Nat.ltb_spec j count) as [_|]; [|lia]; split.
    + apply add_in.
        refine (@TM.eval_correct u span _ (fun s => Xreal (candidate p j s)) _ span (Xreal s) (span_in s Hs)).
        apply models_correct.
      apply room_in; rewrite Rabs_mult, (Rabs_right r) by lra.
      apply Rle_trans with (2 := He j H); pose proof (Rabs_pos (e j)); nra.
    + exists (fun k => if Nat.eqb k j then 1 else 0); split; [apply unit_slopes_within|].
      rewrite sum_unit by easy.
      apply (is_derive_ext (fun r => candidate p j s + r * e j)).
        intros t; rewrite nth_state; destruct (Nat.ltb_spec j count); [easy | lia].
      auto_derive; [easy | ring].
destruct (nth i (slopes_found p) None) as [[x l]|]; [|easy].
destruct (mean_value _ _ _ _ _ M) as [g [G E]].
exists g; split; [exact G|].
assert (E1 : inputs 1 = map (fun j => candidate p j s + e j) (seq 0 count) ++ constants).
  unfold inputs; f_equal; apply map_ext; intros j; ring.
assert (E0 : inputs 0 = candidate_state p s ++ constants).
  unfold inputs, candidate_state; f_equal; apply map_ext; intros j; ring.
now rewrite <- E, E1, E0.
Qed.

Lemma rate_bound (B : nat -> nat -> R) (delta z : nat -> R) k d :
  (forall i, (i < count)%nat ->
     sum count (fun j => twice_part B i j * (balance j / balance i)) <= k - 1) ->
  sum count (fun i => delta i * delta i) <= d ->
  sum count (fun i => 2 * z i * (sum count (fun j => B i j * z j) - delta i))
  <= k * sum count (fun i => z i * z i) + d.
Proof.
intros Q D.
pose proof (quadratic count B balance z (k - 1) balance_positive Q) as P.
assert (S : sum count (fun i => 2 * z i * (sum count (fun j => B i j * z j) - delta i))
  <= sum count (fun i => 2 * (z i * sum count (fun j => B i j * z j)) + (z i * z i + delta i * delta i))).
  apply sum_le; intros i _; pose proof (Rle_0_sqr (z i + delta i)) as N; unfold Rsqr in N; lra.
rewrite !sum_plus, sum_scal in S; lra.
Qed.

Lemma finite_choice n (P : nat -> (nat -> R) -> Prop) :
  (forall i, (i < n)%nat -> exists g, P i g) -> exists G, forall i, (i < n)%nat -> P i (G i).
Proof.
induction n as [|n IH]; intros H; [now exists (fun _ _ => 0)|].
destruct IH as [G HG]; [intros i Hi; apply H; lia|].
destruct (H n ltac:(lia)) as [g Hg].
exists (fun i => if Nat.eqb i n then g else G i).
intros i Hi; destruct (Nat.eqb_spec i n) as [->|N]; [easy | apply HG; lia].
Qed.

(* The error in weights, and the sum of its squares. *)
Definition scaled_error (p : piece) (x : nat -> R -> R) (t s : R) (i : nat) : R :=
  (x i (t + s) - candidate p i s) / weight i.
Definition squares (p : piece) (x : nat -> R -> R) (t s : R) : R :=
  sum count (fun i => scaled_error p x t s i * scaled_error p x t s i).

Lemma square_le p x t s i bound :
  (i < count)%nat -> squares p x t s <= bound ->
  scaled_error p x t s i * scaled_error p x t s i <= bound.
Proof.
intros Hi; apply Rle_trans; unfold squares.
apply (term_le_sum count (fun i => scaled_error p x t s i * scaled_error p x t s i)); [|easy].
intros j _; exact (Rle_0_sqr (scaled_error p x t s j)).
Qed.

Lemma less_by a b x y : a \in x -> b \in y -> is_positive (I.sub prec x y) = true -> b < a.
Proof. intros X Y P; generalize (positive _ _ P (sub_in _ _ _ _ X Y)); lra. Qed.

Lemma over_nonneg n b : (0 <= n)%Z -> (0 <= b)%Z -> 0 <= over n b.
Proof.
intros N B; apply Rmult_le_pos; [now apply IZR_le|].
left; apply Rinv_0_lt_compat, IZR_lt, Z.pow_pos_nonneg; lia.
Qed.

Lemma piece_correct p x until t s :
  check_piece p = true -> motion x until -> 0 <= t -> 0 <= s <= step -> t + s <= until ->
  squares p x t 0 <= over (entry p) 160 ->
  squares p x t s <= over (exit p) 160.
Proof.
unfold check_piece; rewrite !andb_true_iff.
intros [[[[[[Has Rows] Defect] Growth] Exit] Tube] _] Motion Ht Hs Until Entry.
set (z := scaled_error p x t).
set (rate := fun v i => (field i (state x (t + v)) - slope_of (nth i (coefficients p) nil) v) / weight i).
set (growth' := over (growth p) 4); set (defect' := over (defect p) 160).
assert (TubeR : over (exit p) 160 < over tube 160).
  apply Rmult_lt_compat_r; [apply Rinv_0_lt_compat, IZR_lt; lia | apply IZR_lt; now apply Z.ltb_lt].
assert (G0 : 0 <= growth') by (apply over_nonneg; [now apply Z.leb_le | lia]).
assert (Miss : forall v, 0 <= v <= step ->
  sum count (fun i => (slope_of (nth i (coefficients p) nil) v - field i (candidate_state p v)) / weight i
                      * ((slope_of (nth i (coefficients p) nil) v - field i (candidate_state p v)) / weight i))
  <= defect').
  intros v Hv; left; apply less_by with (3 := Defect); [apply scaled_in; lia|].
  apply sum_in; intros i Hi; apply square_is_in, div_in;
    [pose proof (weight_positive i); lra | now apply missing_in | apply weight_is_in].
assert (D0 : 0 <= defect').
  apply Rle_trans with (2 := Miss 0 ltac:(unfold step; lra)).
  apply sum_nonneg; intros i _; apply Rle_0_sqr.
apply stays with (dW := fun v => sum count (fun i => 2 * z v i * rate v i))
  (W := squares p x t) (k := growth') (d := defect') (tube := over tube 160); try easy.
- (* the derivative *)
  intros v Hv; unfold squares.
  apply (is_derive_sum count (fun i v => scaled_error p x t v i * scaled_error p x t v i)
    (fun i v => 2 * z v i * rate v i)).
  intros i Hi.
  assert (Z : is_derive (fun v => scaled_error p x t v i) v (rate v i)).
    unfold scaled_error, rate.
    apply (is_derive_ext (fun v => / weight i * (x i (t + v) - candidate p i v))).
      intros r; unfold Rdiv; apply Rmult_comm.
    replace ((field i (state x (t + v)) - slope_of (nth i (coefficients p) nil) v) / weight i)
      with (/ weight i * (1 * field i (state x (t + v)) - slope_of (nth i (coefficients p) nil) v))
      by (unfold Rdiv; ring).
    apply (is_derive_scal (fun v => x i (t + v) - candidate p i v)).
    apply (is_derive_minus (fun v => x i (t + v)) (candidate p i)); [|apply is_derive_polynomial].
    apply (is_derive_comp (x i) (fun v => t + v)); [apply Motion; [lra | easy]|].
    auto_derive; [easy | ring].
  replace (2 * z v i * rate v i)
    with (rate v i * scaled_error p x t v i + scaled_error p x t v i * rate v i) by (unfold z; ring).
  apply (is_derive_mult (fun v => scaled_error p x t v i) (fun v => scaled_error p x t v i) v _ _ Z Z).
  intros; apply Rmult_comm.
- (* its bound in the tube *)
  intros v Hv Below.
  assert (Hv' : 0 <= v <= step) by lra.
  set (e := fun j => weight j * z v j).
  assert (He : forall j, (j < count)%nat -> Rabs (e j) <= weight j / 2 ^ 24).
    intros j Hj; unfold e; rewrite Rabs_mult, Rabs_right by (pose proof (weight_positive j); lra).
    apply Rmult_le_compat_l; [pose proof (weight_positive j); lra|].
    assert (S : z v j * z v j <= over tube 160) by (apply square_le; [easy | lra]).
    replace (over tube 160) with (/ 2 ^ 24 * / 2 ^ 24) in S.
      assert (P : 0 < / 2 ^ 24) by (apply Rinv_0_lt_compat, pow_lt; lra).
      apply Rabs_le; split; nra.
    unfold over, tube; rewrite <- Rinv_mult.
    rewrite <- pow_add; rewrite (pow_IZR 2 (24 + 24)).
    change (2 ^ 160)%Z with (2 ^ 112 * 2 ^ Z.of_nat (24 + 24))%Z; rewrite mult_IZR.
    field; split; apply IZR_neq, Z.pow_nonzero; lia.
  destruct (finite_choice count (fun i g =>
    (forall j, g j \in slopes_of (nth i (slopes_found p) None) j) /\
    field i (map (fun j => candidate p j v + e j) (seq 0 count)) - field i (candidate_state p v)
    = sum count (fun j => g j * e j))) as [G HG].
    intros i Hi; apply field_difference; [easy | easy|].
    exact (all_states_spec _ i Has Hi).
  assert (E : map (fun j => candidate p j v + e j) (seq 0 count) = state x (t + v)).
    apply map_ext; intros j; unfold e, z, scaled_error.
    field; pose proof (weight_positive j); lra.
  set (B := fun i j => G i j * weight j / weight i).
  set (delta := fun i => (slope_of (nth i (coefficients p) nil) v - field i (candidate_state p v)) / weight i).
  replace (sum count (fun i => 2 * z v i * rate v i))
    with (sum count (fun i => 2 * z v i * (sum count (fun j => B i j * z v j) - delta i))).
    apply rate_bound; [|now apply Miss].
    intros i Hi; left.
    assert (R := all_states_spec _ i Rows Hi); cbv beta in R.
    apply less_by with (3 := R).
      apply sub_in; [apply scaled_in; lia | apply (integer_in 1)].
    assert (Bin : forall j k, (j < count)%nat ->
      B j k \in weighted (fun i => slopes_of (nth i (slopes_found p) None)) j k).
      intros j k Hj; apply div_in; [pose proof (weight_positive j); lra | | apply weight_is_in].
      apply mul_in; [now apply HG | apply weight_is_in].
    apply sum_in; intros j Hj; apply mul_in;
      [|apply div_in; [pose proof (balance_positive i); lra | apply integer_in | apply integer_in]].
    unfold twice_part, twice_part_in.
    destruct (Nat.eqb i j); [apply mul_in; [apply (integer_in 2) | now apply Bin]|].
    now apply abs_in, add_in; apply Bin.
  apply sum_ext; intros i Hi; f_equal.
  destruct (HG i Hi) as [_ F]; rewrite E in F.
  unfold rate, delta.
  replace (field i (state x (t + v)) - slope_of (nth i (coefficients p) nil) v)
    with (sum count (fun j => G i j * e j)
          - (slope_of (nth i (coefficients p) nil) v - field i (candidate_state p v))) by lra.
  replace (sum count (fun j => B i j * z v j)) with (/ weight i * sum count (fun j => G i j * e j)).
    unfold Rdiv; ring.
  rewrite <- sum_scal; apply sum_ext; intros j _; unfold B, e, Rdiv; ring.
- (* what it comes to *)
  intros v Hv.
  assert (X : (over (entry p) 160 + defect' * step) * exp (growth' * step) < over (exit p) 160).
    apply less_by with (3 := Exit); [apply scaled_in; lia|].
    apply mul_in.
      apply add_in; [apply scaled_in; lia | apply mul_in; [apply scaled_in; lia | apply step_is_in]].
    apply exp_in, mul_in; [apply scaled_in; lia | apply step_is_in].
  apply Rle_trans with (2 := Rlt_le _ _ X).
  assert (N : 0 <= squares p x t 0) by (apply sum_nonneg; intros i _; apply Rle_0_sqr).
  apply Rmult_le_compat.
  + apply Rplus_le_le_0_compat; [easy | apply Rmult_le_pos; lra].
  + left; apply exp_pos.
  + apply Rplus_le_compat; [easy | apply Rmult_le_compat_l; lra].
  + assert (L : growth' * v <= growth' * step) by (apply Rmult_le_compat_l; lra).
    destruct L as [L| ->]; [left; now apply exp_increasing | lra].
Qed.

Lemma claimed p x t s i :
  check_piece p = true -> (i < count)%nat -> squares p x t s <= over (exit p) 160 ->
  Rabs (x i (t + s) - candidate p i s) <= error.
Proof.
unfold check_piece; rewrite !andb_true_iff; intros [_ Claim] Hi S.
assert (C := all_states_spec _ i Claim Hi); cbv beta in C.
assert (L : weight i * weight i * over (exit p) 160 < error * error).
  apply less_by with (3 := C).
    apply square_is_in, div_in; [lra | apply (integer_in 1) | apply (integer_in 100000000)].
  apply mul_in; [apply square_is_in, weight_is_in | apply scaled_in; lia].
assert (Q := square_le p x t s i _ Hi S).
pose proof (weight_positive i) as W.
set (d := x i (t + s) - candidate p i s) in *.
assert (E : scaled_error p x t s i = d / weight i) by easy.
assert (D : d * d <= error * error).
  replace (d * d) with (weight i * weight i * (scaled_error p x t s i * scaled_error p x t s i)).
    apply Rle_trans with (2 := Rlt_le _ _ L), Rmult_le_compat_l with (2 := Q).
    apply Rmult_le_pos; lra.
  rewrite E; field; lra.
assert (0 < error) by (unfold error; lra).
apply Rabs_le; split; nra.
Qed.

Lemma jump_correct p q x t :
  check_jump p q = true -> squares p x t step <= over (exit p) 160 ->
  squares q x (t + step) 0 <= over (entry q) 160.
Proof.
intros J S.
set (jump := fun i => (candidate p i step - candidate q i 0) / weight i).
assert (L : over 1025 10 * over (exit p) 160 + 1025 * sum count (fun i => jump i * jump i)
            < over (entry q) 160).
  apply less_by with (3 := J); [apply scaled_in; lia|].
  apply add_in; [apply mul_in; apply scaled_in; lia | apply mul_in; [apply (integer_in 1025)|]].
  apply sum_in; intros i Hi; apply square_is_in, div_in;
    [pose proof (weight_positive i); lra | | apply weight_is_in].
  apply sub_in; apply value_is_in; [apply step_is_in | apply zero_in].
apply Rle_trans with (2 := Rlt_le _ _ L).
apply Rle_trans with (over 1025 10 * squares p x t step + 1025 * sum count (fun i => jump i * jump i)).
  unfold squares; rewrite <- !sum_scal, <- sum_plus; apply sum_le; intros i _.
  replace (scaled_error q x (t + step) 0 i) with (scaled_error p x t step i + jump i).
    set (a := scaled_error p x t step i); set (b := jump i).
    replace (over 1025 10) with (1 + 1 / 1024) by (unfold over; simpl; lra).
    pose proof (Rle_0_sqr (a / 32 - 32 * b)) as N; unfold Rsqr in N; lra.
  unfold scaled_error, jump; rewrite Rplus_0_r; field; pose proof (weight_positive i); lra.
apply Rplus_le_compat_r, Rmult_le_compat_l; [apply over_nonneg; lia | easy].
Qed.

Lemma start_correct p x :
  check_start p = true -> begins x -> squares p x 0 0 <= over (entry p) 160.
Proof.
unfold check_start; rewrite andb_true_iff; intros [Below Start] Begins.
left; apply less_by with (3 := Start); [apply scaled_in; lia|].
apply sum_in; intros i Hi; apply square_is_in, div_in;
  [pose proof (weight_positive i); lra | | apply weight_is_in].
rewrite Rplus_0_r, Begins by easy; apply sub_in; [|apply value_is_in, zero_in].
assert (P := all_states_spec _ i Below Hi); cbv beta in P; apply Z.ltb_lt in P.
destruct (nth i start (0, 1)%Z) as [a b]; cbn [snd] in P.
apply div_in; [apply IZR_neq; lia | apply integer_in | apply integer_in].
Qed.

Lemma chain_correct pieces : forall x until t,
  check_chain pieces = true -> motion x until -> 0 <= t ->
  match pieces with nil => True | p :: _ => t <= until -> squares p x t 0 <= over (entry p) 160 end ->
  forall k p, nth_error pieces k = Some p ->
  forall s, 0 <= s <= step -> t + INR k * step + s <= until ->
  forall i, (i < count)%nat -> Rabs (x i (t + INR k * step + s) - candidate p i s) <= error.
Proof.
induction pieces as [|p rest IH]; intros x until t C M Ht Entry k q Q s Hs U i Hi; [now destruct k|].
cbn [check_chain] in C; rewrite !andb_true_iff in C; destruct C as [[P J] C].
destruct k as [|k].
  injection Q as <-; simpl in U |- *; rewrite Rmult_0_l, Rplus_0_r in *.
  apply claimed; [easy | easy|].
  apply piece_correct with until; try easy; apply Entry; lra.
rewrite S_INR in U |- *.
replace (t + (INR k + 1) * step) with (t + step + INR k * step) in * by ring.
pose proof (pos_INR k).
assert (0 <= INR k * step) by (apply Rmult_le_pos; [easy | unfold step; lra]).
apply (IH x until (t + step)) with (k := k); try easy; [unfold step; lra|].
destruct rest as [|r rest]; [easy|].
intros U'; apply jump_correct with p; [easy|].
apply piece_correct with until; try easy; [unfold step; lra|].
apply Entry; unfold step in *; lra.
Qed.

Theorem enclosed pieces x until :
  check pieces = true -> motion x until -> begins x -> near_candidate x until pieces.
Proof.
unfold check; rewrite andb_true_iff; intros [S C] M B k p P s Hs U i Hi.
replace (INR k * step) with (0 + INR k * step) in * by ring.
apply (chain_correct pieces x until 0); try easy; [lra|].
destruct pieces as [|q rest]; [easy | intros _; now apply start_correct].
Qed.

End Enclosure.

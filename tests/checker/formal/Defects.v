(* Real numbers that the intervals of the checks enclose: the defect and the slopes of a piece. *)
From Coq Require Import Reals QArith Qreals ZArith List Bool Lra Lia.
From Coquelicot Require Import Coquelicot.
From Interval Require Import Xreal Interval.Interval Float_full Tactic_float.
From Interval Require Import Eval.Tree Eval.Prog Eval.Eval.
Require Import Growth Sums Intervals Models Fine Wide Slopes Squares Checks.
Import ListNotations.
Open Scope R_scope.

Section Bicycle.
Variable program : list term.
Variable integers : list Z.
Local Notation constants := (constants integers).
Local Notation field := (field program integers).
Local Notation constants_in := (constants_in integers).
Local Notation rates_of := (rates_of program integers).
Local Notation missing_models := (missing_models program integers).
Local Notation missing_at := (missing_at program integers).
Local Notation missing := (missing program integers).
Local Notation boxes_of := (boxes_of integers).
Local Notation slopes_found := (slopes_found program integers).

Lemma scaled_in n b : (0 <= b)%Z -> over n b \in scaled n b.
Proof. intros H; apply div_in; [now apply power_nonzero | apply integer_in | apply integer_in]. Qed.

Lemma over_nonneg n b : (0 <= n)%Z -> (0 <= b)%Z -> 0 <= over n b.
Proof.
intros N B; apply Rmult_le_pos; [now apply IZR_le|].
left; apply Rinv_0_lt_compat, IZR_lt, Z.pow_pos_nonneg; lia.
Qed.

Lemma rational_in q : Q2R q \in rational q.
Proof. apply div_in; [now apply IZR_neq | apply integer_in | apply integer_in]. Qed.

Lemma length_is_in : 2 * half \in length_in.
Proof.
unfold half; replace (2 * (1 / 32)) with (1 / 16) by field.
apply div_in; [lra | apply (integer_in 1) | apply (integer_in 16)].
Qed.

Lemma span_in s : - half <= s <= half -> s \in span.
Proof. unfold half; intros H; apply stretch_in; [easy | lra]. Qed.

Lemma symmetric_in x y a : y \in a -> Rabs x <= y -> x \in symmetric a.
Proof.
intros Y X; apply between_in with (- y) y; [| |now apply Rabs_le_between].
- apply I.join_correct; left; now apply neg_in.
- apply I.join_correct; now right.
Qed.

Lemma room_in x : Rabs x <= error -> x \in room.
Proof.
apply symmetric_in, div_in; [lra | apply (integer_in 1) | apply (integer_in 100000000)].
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

(* Matrices *)

Definition real (m : list (list Q)) i j : R := Q2R (number m i j).

Lemma matrix_is_in m i j : (i < count)%nat -> (j < count)%nat -> real m i j \in entry (matrix_in m) i j.
Proof. intros Hi Hj; unfold matrix_in; rewrite entry_table by easy; apply rational_in. Qed.

Definition times (a b : nat -> nat -> R) i j := sum count (fun k => a i k * b k j).
Definition inside (a : nat -> nat -> R) (m : list (list I.type)) :=
  forall i j, (i < count)%nat -> (j < count)%nat -> a i j \in entry m i j.

Lemma product_in a b m n : inside a m -> inside b n -> inside (times a b) (product m n).
Proof.
intros A B i j Hi Hj; unfold product; rewrite entry_table by easy.
apply sum_in; intros k Hk; apply mul_in; auto.
Qed.

Lemma squares_are_in a m v w :
  inside a m -> (forall k, (k < count)%nat -> v k \in w k) ->
  sum count (fun i => sum count (fun k => a i k * v k) * sum count (fun k => a i k * v k))
  \in squares_in m w.
Proof.
intros A V; apply sum_in; intros i Hi; apply sqr_in, sum_in; intros k Hk; apply mul_in; auto.
Qed.

Lemma qsum_real n f : Q2R (qsum n f) = sum n (fun i => Q2R (f i)).
Proof. induction n as [|n IH]; simpl; [apply RMicromega.Q2R_0 | now rewrite Q2R_plus, IH]. Qed.

(* Polynomials *)

Lemma models_correct u c :
  TM.approximates span (fst (models u c)) (fun s => Xreal (polynomial c s)) /\
  TM.approximates span (snd (models u c)) (fun s => Xreal (slope_of c s)).
Proof.
induction c as [|a c [P D]]; cbn [models polynomial slope_of].
  split; apply TM.const_correct, zero_in.
destruct (models u c) as [p d]; cbn [fst snd] in *; split.
- apply (@TM.add_correct u span _ _ (fun _ => Xreal (over a grid)) (fun s => Xreal (s * polynomial c s))).
    apply TM.const_correct, scaled_in; easy.
  now apply (@TM.mul_correct u span _ _ Xreal (fun s => Xreal (polynomial c s))); [apply TM.var_correct|].
- apply (@TM.add_correct u span _ _ (fun s => Xreal (polynomial c s)) (fun s => Xreal (s * slope_of c s))); [easy|].
  now apply (@TM.mul_correct u span _ _ Xreal (fun s => Xreal (slope_of c s))); [apply TM.var_correct|].
Qed.

Lemma end_correct sign c :
  polynomial c (IZR sign * half) * (IZR (2 ^ grid) * IZR (32 ^ Z.of_nat (length c))) = IZR (end_of sign c).
Proof.
induction c as [|a c IH]; cbn [polynomial end_of length]; [ring|].
rewrite plus_IZR, !mult_IZR, <- IH, Nat2Z.inj_succ, Z.pow_succ_r, Z.pow_add_r, !mult_IZR by lia.
change (32 ^ 1)%Z with 32%Z; unfold over, half.
pose proof (power_nonzero grid ltac:(easy)); field; easy.
Qed.

Lemma end_value sign c :
  length c = terms -> polynomial c (IZR sign * half) = IZR (end_of sign c) / IZR unity.
Proof.
intros L; rewrite <- end_correct, L.
replace (IZR unity) with (IZR (2 ^ grid) * IZR (32 ^ Z.of_nat terms)) by (rewrite <- mult_IZR; reflexivity).
field; split; apply IZR_neq; easy.
Qed.

(* The defect *)

Definition candidate_state (p : piece) (s : R) : list R := map (fun i => candidate p i s) (seq 0 count).
Definition defect (p : piece) (s : R) (i : nat) : R :=
  slope_of (nth i (coefficients p) nil) s - field i (candidate_state p s).

Lemma nth_state (f : nat -> R) (l : list R) j d :
  nth j (map f (seq 0 count) ++ l) d = if Nat.ltb j count then f j else nth (j - count) l d.
Proof.
destruct (Nat.ltb_spec j count) as [H|H].
  rewrite app_nth1 by now rewrite map_length, seq_length.
  rewrite (nth_indep _ d (f O)) by now rewrite map_length, seq_length.
  now rewrite map_nth, seq_nth.
now rewrite app_nth2, map_length, seq_length by now rewrite map_length, seq_length.
Qed.

Lemma span_bounded : I.convert span <> Inan.
Proof. vm_compute; discriminate. Qed.

Lemma nth_table {A} (f : nat -> A) i d : (i < count)%nat -> nth i (map f (seq 0 count)) d = f i.
Proof.
intros H; rewrite (nth_indep _ d (f O)) by now rewrite map_length, seq_length.
now rewrite map_nth, seq_nth.
Qed.

Lemma rates_correct p i :
  describes span (nth i (rates_of (map (models_of fine p) (seq 0 count))) TM.dummy)
    (fun s => field i (candidate_state p s)).
Proof.
unfold rates_of, field; rewrite map_map; apply fine_program; [exact span_bounded|]; intros j.
destruct (le_lt_dec count j) as [H|H].
- rewrite app_nth2 by now rewrite map_length, seq_length.
  apply describes_ext with (fun _ => nth (j - count) constants 0).
    intros s _; unfold candidate_state; rewrite nth_state; destruct (Nat.ltb_spec j count); [lia | easy].
  rewrite map_length, seq_length.
  destruct constants_within as [L C].
  destruct (le_lt_dec (length constants_in) (j - count)) as [K|K].
    rewrite nth_overflow by (now rewrite map_length); apply dummy_describes.
  rewrite (nth_indep _ TM.dummy (TM.const I.nai)) by now rewrite map_length.
  rewrite map_nth; apply const_describes, C.
- rewrite app_nth1, nth_table by (try rewrite map_length, seq_length; easy).
  apply describes_ext with (candidate p j); [|apply models_correct].
  intros s _; unfold candidate_state; rewrite nth_state; destruct (Nat.ltb_spec j count); [easy | lia].
Qed.

Lemma missing_models_correct p i : (i < count)%nat ->
  describes span (nth i (missing_models p) TM.dummy) (fun s => defect p s i).
Proof.
intros Hi; unfold missing_models, defect; rewrite nth_table by easy; apply sub_describes.
  rewrite nth_table by easy; apply models_correct.
apply rates_correct.
Qed.

Lemma missing_at_correct p i j : (i < count)%nat ->
  defect p (node j) i \in nth i (missing_at (map wide_coefficients (rows p)) j) I.nai.
Proof.
intros Hi; unfold missing_at, defect, field, candidate_state; rewrite nth_table by easy.
replace (nth i (map wide_coefficients (rows p)) nil)
  with (wide_coefficients (nth i (coefficients p) nil)).
  replace (map (fun i => candidate p i (node j)) (seq 0 count))
    with (map (fun c => polynomial c (node j)) (rows p)) by (unfold rows; now rewrite map_map).
  now apply defect_within, fraction_within.
change nil with (wide_coefficients nil) at 2; rewrite map_nth; unfold rows; now rewrite nth_table.
Qed.

Lemma missing_is_in p s i :
  - half <= s <= half -> (i < count)%nat -> defect p s i \in nth i (missing p) I.nai.
Proof.
intros Hs Hi; unfold missing; rewrite nth_table by easy.
apply (between_correct span _ (fun s => defect p s i)).
- intros r Hr; apply span_in; unfold half; lra.
- now apply missing_models_correct.
- rewrite map_map; induction nodes as [|j l IH]; [constructor | constructor; [|exact IH]].
  now apply missing_at_correct.
- unfold half in Hs; lra.
Qed.

(* The slopes *)

Lemma unit_slopes_within time j :
  time \in span -> within span time (fun k => if Nat.eqb k j then 1 else 0) (unit_slopes j).
Proof.
intros T k; unfold unit_slopes.
destruct (Nat.eqb_spec k j) as [->|N].
  rewrite app_nth2; rewrite repeat_length; [|lia].
  rewrite Nat.sub_diag; apply const_reads, (integer_in 1).
destruct (le_lt_dec j k) as [H|H].
  rewrite app_nth2; rewrite repeat_length; [|lia].
  destruct (k - j)%nat as [|m] eqn:E; [lia|]; now destruct m.
rewrite app_nth1 by now rewrite repeat_length.
now rewrite nth_repeat.
Qed.

(* A property that the constants and the paths of the variables have with their boxes *)
Lemma inputs_have (P : (R -> R) -> sloped -> Prop) p (path : nat -> R -> R) :
  (forall a b m, (forall r, a r = b r) -> P a m -> P b m) -> (forall a, P a None) ->
  (forall v a, v \in a -> P (fun _ => v) (Some (TM.const a, nil))) ->
  (forall j, (j < count)%nat ->
    P (path j) (Some (TM.add coarse span (fst (models_of coarse p j)) (TM.const room), unit_slopes j))) ->
  forall j, P (fun r => nth j (map (fun k => path k r) (seq 0 count) ++ constants) 0)
              (nth j (boxes_of p) None).
Proof.
intros Ext None_ Const Path j; unfold boxes_of; destruct (le_lt_dec count j) as [H|H].
- rewrite app_nth2, map_length, seq_length by now rewrite map_length, seq_length.
  destruct constants_within as [L C].
  destruct (le_lt_dec (length constants_in) (j - count)) as [K|K].
    now rewrite nth_overflow by (now rewrite map_length).
  rewrite (nth_indep _ None (Some (TM.const I.nai, nil))) by now rewrite map_length.
  rewrite (map_nth (fun c => Some (TM.const c, nil))).
  apply (Ext (fun _ => nth (j - count) constants 0)); [|apply Const, C].
  intros r; rewrite nth_state; destruct (Nat.ltb_spec j count); [lia | easy].
- rewrite app_nth1 by now rewrite map_length, seq_length.
  set (box := fun i => Some (TM.add coarse span (fst (models_of coarse p i)) (TM.const room), unit_slopes i)).
  rewrite (nth_indep _ None (box O)) by now rewrite map_length, seq_length.
  rewrite (map_nth box), seq_nth by easy.
  apply (Ext (path j)); [|now apply Path].
  intros r; rewrite nth_state; destruct (Nat.ltb_spec j count); [easy | lia].
Qed.

Lemma in_box p s j x :
  s \in span -> Rabs x <= error ->
  reads span s (TM.add coarse span (fst (models_of coarse p j)) (TM.const room)) (candidate p j s + x).
Proof.
intros T X; apply add_reads; [|now apply const_reads, room_in].
exists (fun s => Xreal (candidate p j s)); split; [apply models_correct | easy].
Qed.

(* The difference of the rates in two states of the tube *)
Lemma field_change p s (d e : nat -> R) i :
  - half <= s <= half ->
  (forall j, (j < count)%nat -> Rabs (d j) <= error) ->
  (forall j, (j < count)%nat -> Rabs (e j) <= error) ->
  has_slopes (nth i (slopes_found p) None) = true ->
  exists g, (forall j a, s \in a -> g j \in slope_at (nth i (slopes_found p) None) j a) /\
    field i (map (fun j => candidate p j s + e j) (seq 0 count))
    - field i (map (fun j => candidate p j s + d j) (seq 0 count))
    = sum count (fun j => g j * (e j - d j)).
Proof.
intros Hs Hd He Has; pose proof (span_in s Hs) as T.
set (path := fun j r => candidate p j s + (d j + r * (e j - d j))).
assert (M : moves span s count (fun j => e j - d j)
              (fun r => nth i (eval_real program (map (fun j => path j r) (seq 0 count) ++ constants)) 0)
              (nth i (slopes_found p) None)).
  apply (moves_program coarse span s T _ _ program
    (fun r => map (fun j => path j r) (seq 0 count) ++ constants)).
  apply (inputs_have (moves span s count (fun j => e j - d j))); [| easy | |].
  - intros a b [[x l]|] E A; [|easy]; intros r Hr; destruct (A r Hr) as [X [g [G D]]].
    rewrite <- E; split; [easy|]; exists g; split; [easy | now apply (is_derive_ext a)].
  - intros v a V r _; split; [now apply const_reads|].
    exists (fun _ => 0); split; [intros k; now destruct k|].
    rewrite sum_scal, Rmult_0_l; apply (is_derive_const v).
  - intros j Hj r Hr; split.
      apply in_box; [easy|]; specialize (Hd j Hj); specialize (He j Hj).
      apply Rabs_le_between in Hd; apply Rabs_le_between in He; apply Rabs_le_between; nra.
    exists (fun k => if Nat.eqb k j then 1 else 0); split; [now apply unit_slopes_within|].
    rewrite (sum_unit count j (fun j => e j - d j)) by easy; unfold path; auto_derive; [easy | ring].
destruct (nth i (slopes_found p) None) as [[x l]|]; [|easy].
destruct (mean_value _ _ _ _ _ _ _ M) as [g [G E]].
exists g; split.
  intros j a Ha; simpl; generalize (G j); unfold slope_reads; destruct (nth j l None) as [m|].
    intros R; now apply value_in with s.
  intros ->; apply zero_in.
assert (E1 : map (fun j => path j 1) (seq 0 count)
             = map (fun j => candidate p j s + e j) (seq 0 count)).
  apply map_ext; intros j; unfold path; ring.
assert (E0 : map (fun j => path j 0) (seq 0 count)
             = map (fun j => candidate p j s + d j) (seq 0 count)).
  apply map_ext; intros j; unfold path; ring.
now rewrite E1, E0 in E.
Qed.

Lemma field_difference p s (e : nat -> R) i :
  - half <= s <= half ->
  (forall j, (j < count)%nat -> Rabs (e j) <= error) ->
  has_slopes (nth i (slopes_found p) None) = true ->
  exists g, (forall j a, s \in a -> g j \in slope_at (nth i (slopes_found p) None) j a) /\
    field i (map (fun j => candidate p j s + e j) (seq 0 count)) - field i (candidate_state p s)
    = sum count (fun j => g j * e j).
Proof.
intros Hs He Has; destruct (field_change p s (fun _ => 0) e i Hs) as [g [G E]]; try easy.
  intros _ _; rewrite Rabs_R0; unfold error; lra.
exists g; split; [exact G|].
replace (candidate_state p s) with (map (fun j => candidate p j s + 0) (seq 0 count)).
  rewrite E; apply sum_ext; intros j _; ring.
apply map_ext; intros j; ring.
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

Lemma part_of s : - half <= s <= half -> exists q, (q < parts)%nat /\ s \in part q.
Proof.
intros Hs.
assert (P : forall n, (0 < n)%nat -> s <= (INR n - 8) / 256 ->
  exists q, (q < n)%nat /\ (INR q - 8) / 256 <= s <= (INR q - 7) / 256).
  induction n as [|n IH]; intros N H; [lia|].
  rewrite S_INR in H.
  destruct (Rle_dec s ((INR n - 8) / 256)) as [L|L].
    destruct n as [|n]; [exists O; simpl in *; unfold half in Hs; split; [lia | lra]|].
    destruct (IH ltac:(lia) L) as [q [Hq E]]; exists q; split; [lia | easy].
  exists n; split; [lia | lra].
destruct (P parts) as [q [Hq E]]; [unfold parts; lia | unfold half in Hs; simpl; lra |].
exists q; split; [easy|]; apply stretch_in; [easy|].
rewrite !minus_IZR, <- INR_IZR_INZ; lra.
Qed.

End Bicycle.

(* Theorem 1 for polynomials in one bicycle: why the checks suffice. *)
From Coq Require Import Reals QArith Qreals ZArith List Bool Lra Lia.
From Coquelicot Require Import Coquelicot.
From Interval Require Import Xreal Interval.Interval Float_full Tactic_float.
From Interval Require Import Eval.Tree Eval.Prog Eval.Eval.
Require Import Growth Sums Intervals Models Slopes Squares Defects.
Require Export Checks.
Import ListNotations.
Open Scope R_scope.

Section Bicycle.
Variable program : list term.
Variable integers : list Z.
Variable start : list (Z * Z).
Local Notation field := (field program integers).
Local Notation motion := (motion program integers).
Local Notation begins := (begins start).
Local Notation missing_squares := (missing_squares program integers).
Local Notation slopes_found := (slopes_found program integers).
Local Notation check_piece := (check_piece program integers).
Local Notation distance_in := (distance_in start).
Local Notation check_chain := (check_chain program integers).
Local Notation check_start := (check_start start).
Local Notation check_block := (check_block program integers).
Local Notation defect := (defect program integers).

Section Frame.
Variable c : certificate.
Hypothesis framed : check_frame c = true.
Notation out := (real (frame c)).
Notation back := (real (inverse c)).
Notation wall := (Q2R (tube c)).
Notation accuracy := (Q2R (claim c)).

Lemma frame_parts :
  all_states (fun i => all_states (is_inverse c i)) = true /\ all_states (is_low c) = true.
Proof. generalize framed; unfold check_frame; rewrite !andb_true_iff; tauto. Qed.

Lemma accuracy_between : 0 <= accuracy <= error.
Proof.
generalize framed; unfold check_frame; rewrite !andb_true_iff, !Qle_bool_iff; intros [[_ L] U].
apply Qle_Rle in L, U; rewrite RMicromega.Q2R_0 in L.
replace (Q2R (1 # 100000000)) with error in U by (unfold Q2R, error, Qnum, Qden; field); lra.
Qed.

Lemma inverse_spec i k : is_inverse c i k = true -> times out back i k = if Nat.eqb k i then 1 else 0.
Proof.
unfold is_inverse; intros E; apply Qeq_bool_eq, Qeq_eqR in E; rewrite qsum_real in E.
replace (if Nat.eqb k i then 1 else 0) with (Q2R (if Nat.eqb k i then 1 else 0)%Q).
  rewrite <- E; unfold times; apply sum_ext; intros j _; unfold real; now rewrite Q2R_mult.
destruct (Nat.eqb k i); [apply RMicromega.Q2R_1 | apply RMicromega.Q2R_0].
Qed.

Lemma frame_identity i k :
  (i < count)%nat -> (k < count)%nat -> times out back i k = if Nat.eqb k i then 1 else 0.
Proof.
intros Hi Hk; apply inverse_spec; destruct frame_parts as [F _].
exact (all_states_spec (is_inverse c i) k
  (all_states_spec (fun i => all_states (is_inverse c i)) i F Hi) Hk).
Qed.

Lemma low_spec i :
  is_low c i = true -> sum count (fun j => out i j * out i j) * wall <= accuracy * accuracy.
Proof.
unfold is_low; intros E; apply Qle_bool_iff, Qle_Rle in E.
rewrite !Q2R_mult, qsum_real in E.
apply Rle_trans with (2 := E), Req_le; f_equal.
apply sum_ext; intros j _; unfold real; now rewrite Q2R_mult.
Qed.

Lemma frame_tube i :
  (i < count)%nat -> sum count (fun j => out i j * out i j) * wall <= accuracy * accuracy.
Proof.
intros Hi; apply low_spec; destruct frame_parts as [_ F].
exact (all_states_spec (is_low c) i F Hi).
Qed.

(* The error, its coordinates in the frame, and the sum of their squares *)
Definition gap (p : piece) (x : nat -> R -> R) (t s : R) (i : nat) : R := x i (t + s) - candidate p i s.
Definition coordinate (p : piece) (x : nat -> R -> R) (t s : R) (i : nat) : R :=
  sum count (fun j => back i j * gap p x t s j).
Definition squares (p : piece) (x : nat -> R -> R) (t s : R) : R :=
  sum count (fun i => coordinate p x t s i * coordinate p x t s i).

Lemma squares_nonneg p x t s : 0 <= squares p x t s.
Proof. apply sum_nonneg; intros i _; apply Rle_0_sqr. Qed.

Lemma gap_is p x t s i :
  (i < count)%nat -> gap p x t s i = sum count (fun j => out i j * coordinate p x t s j).
Proof.
intros Hi; unfold coordinate; rewrite sum_product.
rewrite <- (sum_unit count i (gap p x t s) Hi) at 1.
apply sum_ext; intros k Hk; fold (times out back i k); now rewrite frame_identity.
Qed.

Lemma gap_near p x t s i :
  (i < count)%nat -> squares p x t s <= wall -> Rabs (gap p x t s i) <= accuracy.
Proof.
intros Hi S.
assert (G : Rsqr (gap p x t s i) <= Rsqr accuracy).
  rewrite gap_is by easy; apply Rle_trans with (1 := cauchy_schwarz _ _ _).
  apply Rle_trans with (2 := frame_tube i Hi), Rmult_le_compat_l; [|exact S].
  apply sum_nonneg; intros j _; apply Rle_0_sqr.
apply Rsqr_le_abs_0 in G; now rewrite (Rabs_right accuracy) in G by (apply Rle_ge, accuracy_between).
Qed.

Lemma gap_small p x t s i :
  (i < count)%nat -> squares p x t s <= wall -> Rabs (gap p x t s i) <= error.
Proof.
intros Hi S; apply Rle_trans with (2 := proj2 accuracy_between); now apply gap_near.
Qed.

Lemma part_correct k K found q G s z :
  check_part (matrix_in (frame c)) (matrix_in (inverse c)) K found q = true ->
  k \in K -> s \in part q ->
  (forall i j, (i < count)%nat -> (j < count)%nat -> G i j \in slope_at (nth i found None) j (part q)) ->
  2 * sum count (fun i => z i * sum count (fun j => times back (times G out) i j * z j))
  <= k * sum count (fun i => z i * z i).
Proof.
intros C HK Hs HG; set (B := times back (times G out)).
set (M := fun i j => if Nat.eqb i j then k - 2 * B i i else - (B i j + B j i)).
assert (E : forall i j, M i j = k * (if Nat.eqb j i then 1 else 0) - (B i j + B j i)).
  intros i j; unfold M; rewrite (Nat.eqb_sym j i).
  destruct (Nat.eqb_spec i j) as [->|N]; ring.
assert (P : 0 <= form count M z).
  unfold check_part in C; apply nonnegative_correct with (1 := C).
    intros i j; rewrite !E, (Nat.eqb_sym j i); ring.
  intros i j Hi Hj; rewrite entry_table by easy; unfold M.
  set (b := product _ _).
  assert (HB : inside B b).
    apply product_in; [now intros ? ? ? ?; apply matrix_is_in|].
    apply product_in; [|now intros ? ? ? ?; apply matrix_is_in].
    intros i' j' Hi' Hj'; rewrite entry_table by easy; auto.
  destruct (Nat.eqb i j).
    apply sub_in; [easy | apply mul_in; [apply (integer_in 2) | now apply HB]].
  now apply neg_in, add_in; apply HB.
replace (form count M z) with (k * sum count (fun i => z i * z i)
  - 2 * sum count (fun i => z i * sum count (fun j => B i j * z j))) in P; [lra|].
unfold form.
transitivity (sum count (fun i => k * (z i * z i)
  + (-1 * (z i * sum count (fun j => B i j * z j)) + -1 * (z i * sum count (fun j => B j i * z j))))).
  rewrite !sum_plus, !sum_scal.
  replace (sum count (fun i => z i * sum count (fun j => B j i * z j)))
    with (sum count (fun i => z i * sum count (fun j => B i j * z j))); [ring|].
  rewrite sum_product; apply sum_ext; intros j _; rewrite Rmult_comm; f_equal.
  apply sum_ext; intros; ring.
apply sum_ext; intros i Hi.
transitivity (z i * (k * z i - sum count (fun j => B i j * z j) - sum count (fun j => B j i * z j))); [ring|].
f_equal; rewrite <- (sum_unit count i z Hi) at 1.
rewrite <- sum_scal.
transitivity (sum count (fun j => k * ((if Nat.eqb j i then 1 else 0) * z j)
  + (-1 * (B i j * z j) + -1 * (B j i * z j)))).
  rewrite !sum_plus, !sum_scal; ring.
apply sum_ext; intros j _; rewrite E; ring.
Qed.

(* The real number that the bound of a piece encloses *)
Definition real_ratio (w d : R) : R := sqrt (d / (w + d * (2 * half * (2 * half)))).
Definition real_bound (k w d : R) : R :=
  (w + d / real_ratio w d * (2 * half)) * exp ((k + real_ratio w d) * (2 * half)).

Lemma ratio_positive w d : 0 <= w -> 0 < d -> 0 < real_ratio w d.
Proof.
intros W D; apply sqrt_lt_R0, Rmult_lt_0_compat; [easy|].
apply Rinv_0_lt_compat; unfold half; lra.
Qed.

Lemma bound_in k w d K W D :
  0 <= w -> 0 < d -> k \in K -> w \in W -> d \in D -> real_bound k w d \in bound K W D.
Proof.
intros Hw Hd HK HW HD.
assert (R := ratio_positive w d Hw Hd).
assert (HR : real_ratio w d \in ratio W D).
  apply sqrt_in, div_in; [unfold half; lra | easy |].
  apply add_in; [easy | apply mul_in; [easy | apply sqr_in, length_is_in]].
apply mul_in.
  apply add_in; [easy | apply mul_in; [apply div_in; [lra | easy | easy] | apply length_is_in]].
apply exp_in, mul_in; [now apply add_in | apply length_is_in].
Qed.

(* It moves as the equations say where it is in the tube. *)
Definition guided (p : piece) (x : nat -> R -> R) (until t : R) : Prop :=
  forall v, - half <= v <= half -> t + v <= until -> forall i, (i < count)%nat ->
  ex_derive (x i) (t + v) /\
  (squares p x t v < wall -> is_derive (x i) (t + v) (field i (state x (t + v)))).

Lemma motion_guided p x until t : motion x until -> half <= t -> guided p x until t.
Proof.
intros M Ht v Hv U i Hi; assert (D := M (t + v) ltac:(lra) i Hi).
split; [now exists (field i (state x (t + v))) | easy].
Qed.

Lemma piece_correct p x until t s w d :
  check_piece (matrix_in (frame c)) (matrix_in (inverse c)) p = true ->
  guided p x until t -> - half <= s <= half -> t + s <= until ->
  0 < d ->
  (forall v, - half <= v <= half ->
    sum count (fun i => sum count (fun j => back i j * defect p v j)
                        * sum count (fun j => back i j * defect p v j)) <= d) ->
  0 <= w -> squares p x t (- half) <= w ->
  real_bound (over (rate p) 10) w d < wall ->
  squares p x t s <= real_bound (over (rate p) 10) w d.
Proof.
unfold check_piece; rewrite !andb_true_iff.
intros [[[Has _] Rate] Parts] Guided Hs Until D0 Miss W0 Entry Wall.
set (k := over (rate p) 10) in *; set (r := real_ratio w d).
assert (R0 : 0 < r) by now apply ratio_positive.
assert (K0 : 0 <= k) by (apply over_nonneg; [now apply Z.leb_le | lia]).
set (z := coordinate p x t).
set (speed := fun v j => Derive (x j) (t + v) - slope_of (nth j (coefficients p) nil) v).
set (dz := fun v i => sum count (fun j => back i j * speed v j)).
replace s with (s + half - half) by ring.
apply (stays (fun u => squares p x t (u - half))
  (fun u => sum count (fun i => 2 * z (u - half) i * dz (u - half) i)) (s + half) (k + r) (d / r)
  (real_bound k w d) wall); [lra | lra | | | | | exact Wall].
- apply Rmult_le_pos; [lra | left; now apply Rinv_0_lt_compat].
- (* the derivative *)
  intros u Hu; unfold squares.
  apply (is_derive_sum count
    (fun i u => coordinate p x t (u - half) i * coordinate p x t (u - half) i)
    (fun i u => 2 * z (u - half) i * dz (u - half) i)).
  intros i Hi.
  assert (Z : is_derive (fun u => coordinate p x t (u - half) i) u (dz (u - half) i)).
    unfold coordinate, dz.
    apply (is_derive_sum count (fun j u => back i j * gap p x t (u - half) j)
      (fun j u => back i j * speed (u - half) j)).
    intros j Hj; apply (is_derive_scal (fun u => gap p x t (u - half) j)).
    unfold gap, speed.
    apply (is_derive_minus (fun u => x j (t + (u - half))) (fun u => candidate p j (u - half))).
      replace (Derive (x j) (t + (u - half))) with (1 * Derive (x j) (t + (u - half))) by ring.
      apply (is_derive_comp (x j) (fun u => t + (u - half))).
        now apply Derive_correct, (Guided (u - half)); try lra.
      auto_derive; [easy | ring].
    replace (slope_of (nth j (coefficients p) nil) (u - half))
      with (1 * slope_of (nth j (coefficients p) nil) (u - half)) by ring.
    apply (is_derive_comp (candidate p j) (fun u => u - half)); [apply is_derive_polynomial|].
    auto_derive; [easy | ring].
  replace (2 * z (u - half) i * dz (u - half) i)
    with (dz (u - half) i * coordinate p x t (u - half) i + coordinate p x t (u - half) i * dz (u - half) i)
    by (unfold z; ring).
  apply (is_derive_mult (fun u => coordinate p x t (u - half) i)
    (fun u => coordinate p x t (u - half) i) u _ _ Z Z); intros; apply Rmult_comm.
- (* its bound in the tube *)
  intros u Hu Below; set (v := u - half) in *.
  assert (Hv : - half <= v <= half) by (unfold v; lra).
  destruct (part_of v Hv) as [q [Hq Part]].
  assert (Check : check_part (matrix_in (frame c)) (matrix_in (inverse c)) (scaled (rate p) 10)
                    (slopes_found p) q = true).
    rewrite forallb_forall in Parts; apply Parts, in_seq; lia.
  destruct (finite_choice count (fun i g =>
    (forall j a, v \in a -> g j \in slope_at (nth i (slopes_found p) None) j a) /\
    field i (map (fun j => candidate p j v + gap p x t v j) (seq 0 count)) - field i (candidate_state p v)
    = sum count (fun j => g j * gap p x t v j))) as [G HG].
    intros i Hi; apply field_difference; [easy | | exact (all_states_spec _ i Has Hi)].
    intros j Hj; apply gap_small; [easy | lra].
  assert (E : map (fun j => candidate p j v + gap p x t v j) (seq 0 count) = state x (t + v)).
    apply map_ext; intros j; unfold gap; ring.
  assert (Moves : forall j, (j < count)%nat -> is_derive (x j) (t + v) (field j (state x (t + v)))).
    intros j Hj; now apply (Guided v Hv ltac:(unfold v; lra) j Hj).
  set (B := times back (times G out)).
  set (miss := fun i => sum count (fun j => back i j * defect p v j)).
  assert (Dz : forall i, dz v i = sum count (fun j => B i j * z v j) - miss i).
    intros i; unfold dz, miss.
    transitivity (sum count (fun j => back i j * sum count (fun l => times G out j l * z v l)
                                      + -1 * (back i j * defect p v j))).
      apply sum_ext; intros j Hj.
      destruct (HG j Hj) as [_ F]; rewrite E in F.
      replace (speed v j) with (sum count (fun l => G j l * gap p x t v l) - defect p v j)
        by (unfold speed, defect; rewrite (is_derive_unique _ _ _ (Moves j Hj)); lra).
      replace (sum count (fun l => G j l * gap p x t v l))
        with (sum count (fun l => times G out j l * z v l)); [ring|].
      transitivity (sum count (fun l => G j l * sum count (fun m => out l m * z v m))).
        symmetry; exact (sum_product count count (G j) out (z v)).
      apply sum_ext; intros l Hl; f_equal; symmetry; now apply gap_is.
    rewrite sum_plus, sum_scal, (sum_product count count (back i) (times G out) (z v)).
    unfold Rminus; apply f_equal2; [apply sum_ext; reflexivity | ring].
  assert (Grow : 2 * sum count (fun i => z v i * sum count (fun j => B i j * z v j))
                 <= k * sum count (fun i => z v i * z v i)).
    apply (part_correct k (scaled (rate p) 10) (slopes_found p) q G v (z v));
      [easy | apply scaled_in; lia | easy |].
    intros i j Hi Hj; apply HG; [easy | exact Part].
  apply Rle_trans with (sum count (fun i => 2 * (z v i * sum count (fun j => B i j * z v j))
    + (r * (z v i * z v i) + / r * (miss i * miss i)))).
    apply sum_le; intros i Hi; rewrite Dz.
    assert (N : 0 <= / r * ((r * z v i + miss i) * (r * z v i + miss i))).
      apply Rmult_le_pos; [left; now apply Rinv_0_lt_compat | apply Rle_0_sqr].
    replace (/ r * ((r * z v i + miss i) * (r * z v i + miss i)))
      with (r * (z v i * z v i) + / r * (miss i * miss i) + 2 * (z v i * miss i)) in N by (field; lra).
    lra.
  rewrite !sum_plus, !sum_scal.
  apply Rle_trans with (k * squares p x t v + (r * squares p x t v + / r * d)).
    apply Rplus_le_compat; [exact Grow|]; apply Rplus_le_compat_l.
    apply Rmult_le_compat_l; [left; now apply Rinv_0_lt_compat | exact (Miss v Hv)].
  apply Req_le; unfold Rdiv; ring.
- (* the bound at the end *)
  intros u Hu; unfold real_bound; fold r.
  replace (0 - half) with (- half) by ring.
  pose proof (squares_nonneg p x t (- half)).
  assert (Q0 : 0 <= d / r) by (apply Rmult_le_pos; [lra | left; now apply Rinv_0_lt_compat]).
  apply Rmult_le_compat.
  + apply Rplus_le_le_0_compat; [easy | apply Rmult_le_pos; lra].
  + left; apply exp_pos.
  + apply Rplus_le_compat; [easy | apply Rmult_le_compat_l; lra].
  + assert (L : (k + r) * u <= (k + r) * (2 * half)) by (apply Rmult_le_compat_l; lra).
    destruct L as [L|E]; [left; now apply exp_increasing | rewrite E; lra].
Qed.

(* Rounding up *)
Lemma above_in a x : x \in a -> exists y, y \in above a.
Proof.
intros X; set (b := I.add prec (I.mul prec (scaled 2049 10) a) (scaled 1 150)).
assert (N : not_empty (I.convert b)).
  exists (over 2049 10 * x + over 1 150).
  apply add_in; [apply mul_in; [apply scaled_in; lia | easy] | apply scaled_in; lia].
eexists; exact (A.J.contains_midpoint b N).
Qed.

(* The jump between two pieces, and the distance of the first one from the initial state *)
Definition jump (p q : piece) (i : nat) : R := candidate p i half - candidate q i (- half).

Lemma jump_is_in p q i :
  length (nth i (coefficients p) nil) = terms -> length (nth i (coefficients q) nil) = terms ->
  jump p q i \in jump_in p q i.
Proof.
intros P Q; unfold jump, candidate.
replace half with (IZR 1 * half) at 1 by ring.
replace (- half) with (IZR (-1) * half) by ring.
rewrite !end_value by easy.
replace (IZR (end_of 1 (nth i (coefficients p) nil)) / IZR unity
         - IZR (end_of (-1) (nth i (coefficients q) nil)) / IZR unity)
  with (IZR (end_of 1 (nth i (coefficients p) nil) - end_of (-1) (nth i (coefficients q) nil)) / IZR unity)
  by (rewrite minus_IZR; unfold Rdiv; ring).
apply div_in; [now apply IZR_neq | apply integer_in | apply integer_in].
Qed.

Lemma distance_is_in p x i :
  (i < count)%nat -> begins x -> Z.ltb 0 (snd (nth i start (0, 1)%Z)) = true ->
  length (nth i (coefficients p) nil) = terms -> gap p x half (- half) i \in distance_in p i.
Proof.
intros Hi B Below L; unfold gap, candidate, distance_in.
replace (half + - half) with 0 by ring; rewrite B by easy.
replace (- half) with (IZR (-1) * half) by ring; rewrite end_value by easy.
destruct (nth i start (0, 1)%Z) as [a b]; cbn [snd] in Below; apply Z.ltb_lt in Below.
assert (U : IZR unity <> 0) by now apply IZR_neq.
assert (V : IZR b <> 0) by (apply IZR_neq; lia).
set (e := end_of _ _).
replace (IZR a / IZR b - IZR e / IZR unity) with (IZR (a * unity - b * e) / IZR (b * unity))
  by (rewrite minus_IZR, !mult_IZR; field; easy).
apply div_in; [|apply integer_in | apply integer_in].
rewrite mult_IZR; now apply Rmult_integral_contrapositive.
Qed.

Definition turned (v : nat -> R) (i : nat) : R := sum count (fun j => back i j * v j).
Definition turned_squares (v : nat -> R) : R := sum count (fun i => turned v i * turned v i).

Lemma turned_nonneg v : 0 <= turned_squares v.
Proof. apply sum_nonneg; intros i _; apply Rle_0_sqr. Qed.

Lemma turned_in v w :
  (forall i, (i < count)%nat -> v i \in w i) ->
  turned_squares v \in squares_in (matrix_in (inverse c)) w.
Proof. intros V; apply squares_are_in; [intros i j; apply matrix_is_in | easy]. Qed.

Definition real_share (w j : R) : R := sqrt ((j + over 1 200) / (w + (j + over 1 200))).
Definition real_after (w j : R) : R := (1 + real_share w j) * w + (1 + / real_share w j) * j.

Lemma tiny_positive : 0 < over 1 200.
Proof. apply Rmult_lt_0_compat; [lra | now apply Rinv_0_lt_compat, IZR_lt]. Qed.

Lemma share_positive w j : 0 <= w -> 0 <= j -> 0 < real_share w j.
Proof.
intros W J; pose proof tiny_positive.
apply sqrt_lt_R0, Rmult_lt_0_compat; [lra | apply Rinv_0_lt_compat; lra].
Qed.

Lemma after_in w j W J :
  0 <= w -> 0 <= j -> w \in W -> j \in J -> real_after w j \in after_jump W J.
Proof.
intros Hw Hj HW HJ; pose proof tiny_positive as T.
assert (S := share_positive w j Hw Hj).
assert (E : j + over 1 200 \in I.add prec J (scaled 1 200)) by (apply add_in; [easy | apply scaled_in; lia]).
assert (HS : real_share w j \in share W J).
  apply sqrt_in, div_in; [lra | easy | now apply add_in].
apply add_in; apply mul_in; try easy; apply add_in; try apply (integer_in 1); [easy|].
apply A.J.inv_correct, HS.
Qed.

Lemma jump_correct p q x t w :
  0 <= w -> squares p x t half <= w ->
  squares q x (t + 2 * half) (- half) <= real_after w (turned_squares (jump p q)).
Proof.
intros W S; set (j := turned_squares (jump p q)); set (r := real_share w j).
assert (J : 0 <= j) by apply turned_nonneg.
assert (P : 0 < r) by now apply share_positive.
apply Rle_trans with ((1 + r) * squares p x t half + (1 + / r) * j).
  2: { unfold real_after; fold r; apply Rplus_le_compat_r, Rmult_le_compat_l; lra. }
unfold squares, j, turned_squares; rewrite <- !sum_scal, <- sum_plus; apply sum_le; intros i _.
replace (coordinate q x (t + 2 * half) (- half) i) with (coordinate p x t half i + turned (jump p q) i).
  set (a := coordinate p x t half i); set (b := turned (jump p q) i).
  assert (N : 0 <= / r * ((r * a - b) * (r * a - b))).
    apply Rmult_le_pos; [left; now apply Rinv_0_lt_compat | apply Rle_0_sqr].
  replace (/ r * ((r * a - b) * (r * a - b))) with (r * (a * a) + / r * (b * b) - 2 * (a * b)) in N
    by (field; lra).
  lra.
unfold coordinate, turned; rewrite <- sum_plus; apply sum_ext; intros k _.
unfold gap, jump; replace (t + 2 * half + - half) with (t + half) by ring; ring.
Qed.

Lemma terms_of p i : has_terms p = true -> (i < count)%nat -> length (nth i (coefficients p) nil) = terms.
Proof. intros L Hi; now apply Nat.eqb_eq, (all_states_spec _ i L). Qed.

Lemma piece_terms p i :
  check_piece (matrix_in (frame c)) (matrix_in (inverse c)) p = true -> (i < count)%nat ->
  length (nth i (coefficients p) nil) = terms.
Proof.
unfold check_piece; rewrite !andb_true_iff; intros [[[_ L] _] _] Hi; now apply terms_of.
Qed.

(* The first piece of a list that passes the check has as many terms as it should have. *)
Lemma first_checked out' back' limit next W p rest :
  check_chain out' back' limit next W (p :: rest) = true -> check_piece out' back' p = true.
Proof. cbn [check_chain]; rewrite !andb_true_iff; tauto. Qed.

Lemma half_positive : 0 < half.
Proof. unfold half; lra. Qed.

(* The bound of the first piece of a list that passes the check *)
Lemma first_correct p rest next W w x until t :
  check_chain (matrix_in (frame c)) (matrix_in (inverse c)) (rational (tube c)) next W (p :: rest) = true ->
  guided p x until t -> 0 <= w -> w \in W ->
  (t - half <= until -> squares p x t (- half) <= w) ->
  exists b, 0 <= b /\ b < wall /\
    b \in bound (scaled (rate p) 10) W (above (missing_squares (matrix_in (inverse c)) p)) /\
    forall v, - half <= v <= half -> t + v <= until -> squares p x t v <= b.
Proof.
intros C M W0 HW Entry; pose proof half_positive as H0.
assert (Piece := first_checked _ _ _ _ _ _ _ C).
cbn [check_chain] in C; rewrite !andb_true_iff in C; destruct C as [[[[_ Above] Positive] Low] _].
assert (Miss : forall v, - half <= v <= half ->
  turned_squares (defect p v) \in missing_squares (matrix_in (inverse c)) p).
  intros v Hv; apply turned_in; intros j Hj; now apply missing_is_in.
destruct (above_in _ _ (Miss 0 ltac:(lra))) as [d D].
assert (D0 := positive _ _ Positive D).
assert (K : over (rate p) 10 \in scaled (rate p) 10) by (apply scaled_in; lia).
assert (B := bound_in _ w d _ _ _ W0 D0 K HW D).
assert (L : real_bound (over (rate p) 10) w d < wall) by exact (less_by _ _ _ _ (rational_in (tube c)) B Low).
exists (real_bound (over (rate p) 10) w d).
split; [|split; [exact L | split; [exact B|]]].
  pose proof (Rinv_0_lt_compat _ (ratio_positive w d W0 D0)) as H.
  unfold real_bound; apply Rmult_le_pos; [|left; apply exp_pos].
  apply Rplus_le_le_0_compat; [exact W0|]; apply Rmult_le_pos; [|lra].
  apply Rmult_le_pos; [left; exact D0 | left; exact H].
intros v Hv V.
assert (Missed : forall r, - half <= r <= half -> turned_squares (defect p r) <= d).
  intros r Hr; left; exact (less_by _ _ _ _ D (Miss r Hr) Above).
assert (Begin : squares p x t (- half) <= w) by (apply Entry; lra).
exact (piece_correct p x until t v w d Piece M Hv V D0 Missed W0 Begin L).
Qed.

Lemma after_nonneg w j : 0 <= w -> 0 <= j -> 0 <= real_after w j.
Proof.
intros W J; pose proof (share_positive w j W J) as S; pose proof (Rinv_0_lt_compat _ S).
apply Rplus_le_le_0_compat; apply Rmult_le_pos; lra.
Qed.

Lemma chain_correct pieces : forall x until t w W next,
  check_chain (matrix_in (frame c)) (matrix_in (inverse c)) (rational (tube c)) next W pieces = true ->
  motion x until -> half <= t ->
  0 <= w -> w \in W ->
  match pieces with nil => True | p :: _ => t - half <= until -> squares p x t (- half) <= w end ->
  (forall k p, nth_error pieces k = Some p ->
   forall s, - half <= s <= half -> t + 2 * INR k * half + s <= until ->
   forall i, (i < count)%nat -> Rabs (x i (t + 2 * INR k * half + s) - candidate p i s) <= accuracy) /\
  (forall q e, next = Some (q, e) -> pieces <> nil ->
   t + 2 * INR (length pieces) * half - half <= until ->
   squares q x (t + 2 * INR (length pieces) * half) (- half) <= Q2R e).
Proof.
pose proof half_positive as H0.
induction pieces as [|p rest IH]; intros x until t w W next C M Ht W0 HW Entry.
  split; [intros k q Q; destruct k; discriminate Q | intros q e _ N; now elim N].
assert (Piece := first_checked _ _ _ _ _ _ _ C).
destruct (first_correct p rest next W w x until t C (motion_guided p x until t M Ht) W0 HW Entry) as [b [B0 [L [B Inside]]]].
cbn [check_chain] in C; rewrite !andb_true_iff in C; destruct C as [_ C].
assert (First : forall s, - half <= s <= half -> t + s <= until ->
  forall i, (i < count)%nat -> Rabs (x i (t + s) - candidate p i s) <= accuracy).
  intros s Hs U i Hi; apply (gap_near p x t s i Hi); specialize (Inside s Hs U); lra.
destruct rest as [|r rest].
- split.
    intros k q Q s Hs U i Hi; destruct k as [|k]; [|destruct k; discriminate Q].
    injection Q as <-; replace (t + 2 * INR 0 * half + s) with (t + s) in * by (simpl; ring).
    now apply First.
  intros q e N _ U; rewrite N in C; apply andb_true_iff in C; destruct C as [T P].
  simpl length in *; replace (t + 2 * INR 1 * half) with (t + 2 * half) in * by (simpl; ring).
  apply Rle_trans with (real_after b (turned_squares (jump p q))).
    apply jump_correct; [exact B0 | apply Inside; lra].
  left; refine (less_by _ _ _ _ (rational_in e) _ P).
  apply after_in; [exact B0 | apply turned_nonneg | exact B |].
  apply turned_in; intros j Hj; apply jump_is_in; [exact (piece_terms p j Piece Hj)|].
  exact (terms_of q j T Hj).
- destruct (IH x until (t + 2 * half) (real_after b (turned_squares (jump p r)))
    (after_jump (bound (scaled (rate p) 10) W (above (missing_squares (matrix_in (inverse c)) p)))
       (squares_in (matrix_in (inverse c)) (jump_in p r))) next) as [Near End];
    [exact C | exact M | lra | apply after_nonneg; [exact B0 | apply turned_nonneg] | | |].
  + apply after_in; [exact B0 | apply turned_nonneg | exact B |].
    apply turned_in; intros j Hj; apply jump_is_in; [exact (piece_terms p j Piece Hj)|].
    exact (piece_terms r j (first_checked _ _ _ _ _ _ _ C) Hj).
  + intros V; apply jump_correct; [exact B0 | apply Inside; lra].
  + split.
      intros k q Q s Hs U i Hi; destruct k as [|k].
        injection Q as <-; replace (t + 2 * INR 0 * half + s) with (t + s) in * by (simpl; ring).
        now apply First.
      rewrite S_INR in U |- *.
      replace (t + 2 * (INR k + 1) * half + s) with (t + 2 * half + 2 * INR k * half + s) in * by ring.
      exact (Near k q Q s Hs U i Hi).
    intros q e N _; change (length (p :: r :: rest)) with (S (length (r :: rest))); rewrite S_INR.
    replace (t + 2 * (INR (length (r :: rest)) + 1) * half)
      with (t + 2 * half + 2 * INR (length (r :: rest)) * half) by ring.
    apply End; [exact N | discriminate].
Qed.

(* All blocks pass, each with the next one. *)
Fixpoint all_checked (blocks : list block) : Prop :=
  match blocks with
  | nil => True
  | b :: rest => check_block c b (match rest with nil => None | n :: _ => Some n end) = true
      /\ members b <> nil /\ 0 <= Q2R (entry_of b) /\ all_checked rest
  end.

Lemma blocks_correct blocks : forall x until t,
  all_checked blocks -> motion x until -> half <= t ->
  match blocks with
  | nil => True
  | b :: _ => forall p, nth_error (members b) 0 = Some p ->
      t - half <= until -> squares p x t (- half) <= Q2R (entry_of b)
  end ->
  forall k p, nth_error (concat (map members blocks)) k = Some p ->
  forall s, - half <= s <= half -> t + 2 * INR k * half + s <= until ->
  forall i, (i < count)%nat -> Rabs (x i (t + 2 * INR k * half + s) - candidate p i s) <= accuracy.
Proof.
pose proof half_positive as H0.
induction blocks as [|b rest IH]; intros x until t A M Ht Entry k p P s Hs U i Hi;
  [destruct k; discriminate P|].
destruct A as [C [Some_ [E0 A]]]; unfold check_block in C.
destruct (chain_correct (members b) x until t (Q2R (entry_of b)) (rational (entry_of b)) _ C M Ht E0
  (rational_in (entry_of b))) as [Near End].
  destruct (members b) as [|q l]; [exact Logic.I | exact (Entry q eq_refl)].
simpl concat in P; destruct (le_lt_dec (length (members b)) k) as [L|L].
  rewrite nth_error_app2 in P by easy.
  replace (t + 2 * INR k * half + s)
    with (t + 2 * INR (length (members b)) * half + 2 * INR (k - length (members b)) * half + s) in *
    by (rewrite minus_INR by easy; ring).
  pose proof (pos_INR (length (members b))) as N.
  apply (IH x until (t + 2 * INR (length (members b)) * half) A M); try assumption.
    assert (0 <= INR (length (members b)) * half) by (apply Rmult_le_pos; lra); lra.
  destruct rest as [|n rest]; [exact Logic.I|]; intros q Q.
  unfold first_of in End; destruct (members n) as [|q' l] eqn:F; [discriminate Q|].
  injection Q as ->; intros V; now apply End.
rewrite nth_error_app1 in P by easy; now apply (Near k p P).
Qed.

End Frame.

Lemma start_framed c b : check_start c b = true -> check_frame c = true.
Proof.
unfold check_start; destruct (members b) as [|p l]; [discriminate|]; rewrite !andb_true_iff; tauto.
Qed.

(* The blocks of a certificate, of which the first begins near the initial state. *)
Theorem enclosed c b rest x until :
  check_start c b = true -> all_checked c (b :: rest) -> motion x until -> begins x ->
  near_candidate x until (concat (map members (b :: rest))) (Q2R (claim c)).
Proof.
intros St A M B k p P s Hs U i Hi.
unfold check_start in St; destruct (members b) as [|q l] eqn:E; [discriminate St|].
rewrite !andb_true_iff in St; destruct St as [[[F T] Below] Low].
replace (middle k) with (half + 2 * INR k * half) in * by (unfold middle; ring).
apply (blocks_correct c F (b :: rest) x until half A M (Rle_refl half)) with (k := k);
  [|exact P | exact Hs | exact U | exact Hi].
intros q' Q _; rewrite E in Q; injection Q as <-.
left; refine (less_by _ _ _ _ (rational_in (entry_of b)) _ Low).
apply turned_in; intros j Hj; apply distance_is_in; [exact Hj | exact B | |].
  exact (all_states_spec _ j Below Hj).
exact (terms_of q j T Hj).
Qed.
End Bicycle.

Lemma entry_nonneg b : Qle_bool 0 (entry_of b) = true -> 0 <= Q2R (entry_of b).
Proof. intros H; apply Qle_bool_iff, Qle_Rle in H; now rewrite RMicromega.Q2R_0 in H. Qed.

(* At each time that the pieces cover, the motion is near one of them. *)
Lemma covered x until pieces accuracy :
  near_candidate x until pieces accuracy -> forall t, 0 <= t <= until ->
  t <= 2 * INR (length pieces) * half -> (0 < length pieces)%nat ->
  exists p s, In p pieces /\ - half <= s <= half /\
  forall i, (i < count)%nat -> Rabs (x i t - candidate p i s) <= accuracy.
Proof.
intros Near t Ht L N; assert (H0 : 0 < half) by (unfold half; lra).
assert (K : exists k, (k < length pieces)%nat /\ 2 * INR k * half <= t <= 2 * INR k * half + 2 * half).
  clear Near; induction (length pieces) as [|n IH]; [lia|].
  rewrite S_INR in L; destruct (Rle_dec t (2 * INR n * half)) as [T|T].
    destruct n as [|n]; [exists O; simpl in *; split; [lia | lra]|].
    destruct (IH T ltac:(lia)) as [k [Hk E]]; exists k; split; [lia | exact E].
  exists n; split; [lia | lra].
destruct K as [k [Hk E]].
destruct (nth_error pieces k) as [p|] eqn:P; [|now apply nth_error_None in P; apply Nat.lt_nge in Hk].
exists p, (t - middle k); split; [now apply nth_error_In with k|].
assert (S : - half <= t - middle k <= half) by (unfold middle; lra).
split; [exact S|]; intros i Hi.
replace t with (middle k + (t - middle k)) at 1 by ring.
apply (Near k p P); [exact S | lra | exact Hi].
Qed.

(* 160 pieces cover ten seconds. *)
Lemma ten_seconds_covered x pieces accuracy :
  near_candidate x 10 pieces accuracy -> length pieces = 160%nat ->
  forall t, 0 <= t <= 10 -> exists p s, In p pieces /\ - half <= s <= half /\
  forall i, (i < count)%nat -> Rabs (x i t - candidate p i s) <= accuracy.
Proof.
intros Near L t Ht; apply (covered x 10 pieces accuracy Near t Ht); rewrite L; [|lia].
unfold half; simpl; lra.
Qed.

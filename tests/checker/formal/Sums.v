(* Finite sums, and a quadratic form bounded by its symmetric part's rows. *)
From Coq Require Import Reals Lra Lia Arith.
From Coquelicot Require Import Coquelicot.
Open Scope R_scope.

Fixpoint sum (n : nat) (f : nat -> R) : R :=
  match n with O => 0 | S m => sum m f + f m end.

Lemma sum_ext n f g : (forall i, (i < n)%nat -> f i = g i) -> sum n f = sum n g.
Proof.
induction n as [|n IH]; intros H; [easy|]; simpl.
rewrite IH, H; auto.
Qed.

Lemma sum_le n f g : (forall i, (i < n)%nat -> f i <= g i) -> sum n f <= sum n g.
Proof.
induction n as [|n IH]; intros H; simpl; [lra|].
apply Rplus_le_compat; auto.
Qed.

Lemma sum_plus n f g : sum n (fun i => f i + g i) = sum n f + sum n g.
Proof. induction n as [|n IH]; simpl; [|rewrite IH]; lra. Qed.

Lemma sum_scal n c f : sum n (fun i => c * f i) = c * sum n f.
Proof. induction n as [|n IH]; simpl; [|rewrite IH]; lra. Qed.

Lemma sum_swap n m f :
  sum n (fun i => sum m (fun j => f i j)) = sum m (fun j => sum n (fun i => f i j)).
Proof.
induction n as [|n IH]; simpl.
  induction m as [|m IH]; simpl; lra.
now rewrite IH, sum_plus.
Qed.

Lemma sum_nonneg n f : (forall i, (i < n)%nat -> 0 <= f i) -> 0 <= sum n f.
Proof.
induction n as [|n IH]; intros H; simpl; [lra|].
apply Rplus_le_le_0_compat; auto.
Qed.

Lemma term_le_sum n f i : (forall j, (j < n)%nat -> 0 <= f j) -> (i < n)%nat -> f i <= sum n f.
Proof.
induction n as [|n IH]; intros H Hi; [lia|]; simpl.
destruct (Nat.eq_dec i n) as [->|N].
  assert (0 <= sum n f) by (apply sum_nonneg; auto); lra.
assert (f i <= sum n f) by (apply IH; [auto | lia]).
assert (0 <= f n) by auto; lra.
Qed.

Lemma is_derive_sum n (f df : nat -> R -> R) s :
  (forall i, (i < n)%nat -> is_derive (f i) s (df i s)) ->
  is_derive (fun u => sum n (fun i => f i u)) s (sum n (fun i => df i s)).
Proof.
induction n as [|n IH]; intros H; simpl.
  exact (is_derive_const 0 s).
exact (is_derive_plus _ _ _ _ _ (IH (fun i Hi => H i ltac:(lia))) (H n ltac:(lia))).
Qed.

(* Entries of the symmetric part of B, twice, in absolute value off the diagonal. *)
Definition twice_part (B : nat -> nat -> R) i j :=
  if Nat.eqb i j then 2 * B i i else Rabs (B i j + B j i).

(* Rows are balanced by positive numbers v. *)
Lemma quadratic n (B : nat -> nat -> R) (v z : nat -> R) (k : R) :
  (forall i, 0 < v i) ->
  (forall i, (i < n)%nat -> sum n (fun j => twice_part B i j * (v j / v i)) <= k) ->
  2 * sum n (fun i => z i * sum n (fun j => B i j * z j)) <= k * sum n (fun i => z i * z i).
Proof.
intros V H.
set (M := twice_part B).
assert (Sym : forall i j, M i j = M j i).
  intros i j; unfold M, twice_part; rewrite (Nat.eqb_sym j i).
  destruct (Nat.eqb_spec i j) as [->|_]; [easy|]; now rewrite Rplus_comm.
set (half := fun i j => M i j * (v j / v i) * (z i * z i) / 2).
apply Rle_trans with (sum n (fun i => sum n (fun j => half i j + half j i))).
- replace (2 * sum n (fun i => z i * sum n (fun j => B i j * z j)))
    with (sum n (fun i => sum n (fun j => (B i j + B j i) * z i * z j))).
    apply sum_le; intros i _; apply sum_le; intros j _.
    unfold half; rewrite (Sym j i); unfold M, twice_part.
    pose proof (V i) as Vi; pose proof (V j) as Vj.
    destruct (Nat.eqb_spec i j) as [->|_]; [apply Req_le; field; lra|].
    set (c := B i j + B j i).
    assert (c * (z i * z j) <= Rabs c * Rabs (z i * z j)).
      rewrite <- Rabs_mult; apply Rle_abs.
    assert (Rabs (z i * z j) <= (v j / v i * (z i * z i) + v i / v j * (z j * z j)) / 2).
      assert (P : 0 <= (v j * z i + v i * z j) * (v j * z i + v i * z j) / (v i * v j)).
        apply Rmult_le_pos; [apply Rle_0_sqr | left; apply Rinv_0_lt_compat, Rmult_lt_0_compat; easy].
      assert (Q : 0 <= (v j * z i - v i * z j) * (v j * z i - v i * z j) / (v i * v j)).
        apply Rmult_le_pos; [apply Rle_0_sqr | left; apply Rinv_0_lt_compat, Rmult_lt_0_compat; easy].
      replace ((v j * z i + v i * z j) * (v j * z i + v i * z j) / (v i * v j))
        with (v j / v i * (z i * z i) + v i / v j * (z j * z j) + 2 * (z i * z j)) in P by (field; lra).
      replace ((v j * z i - v i * z j) * (v j * z i - v i * z j) / (v i * v j))
        with (v j / v i * (z i * z i) + v i / v j * (z j * z j) - 2 * (z i * z j)) in Q by (field; lra).
      apply Rabs_le; split; lra.
    pose proof (Rmult_le_compat_l (Rabs c) _ _ (Rabs_pos c) H1); lra.
  transitivity (sum n (fun i => sum n (fun j => B i j * z i * z j))
                + sum n (fun i => sum n (fun j => B j i * z i * z j))).
    rewrite <- sum_plus; apply sum_ext; intros i _.
    rewrite <- sum_plus; apply sum_ext; intros j _; ring.
  rewrite (sum_swap n n (fun i j => B j i * z i * z j)).
  replace (sum n (fun j => sum n (fun i => B j i * z i * z j)))
    with (sum n (fun i => sum n (fun j => B i j * z i * z j))).
    replace (sum n (fun i => z i * sum n (fun j => B i j * z j)))
      with (sum n (fun i => sum n (fun j => B i j * z i * z j))); [ring|].
    apply sum_ext; intros i _; rewrite <- sum_scal; apply sum_ext; intros j _; ring.
  apply sum_ext; intros i _; apply sum_ext; intros j _; ring.
- replace (sum n (fun i => sum n (fun j => half i j + half j i)))
    with (sum n (fun i => z i * z i * sum n (fun j => M i j * (v j / v i)))).
    rewrite <- sum_scal; apply sum_le; intros i Hi.
    rewrite (Rmult_comm k); apply Rmult_le_compat_l; [apply Rle_0_sqr | exact (H i Hi)].
  transitivity (sum n (fun i => sum n (fun j => half i j)) + sum n (fun i => sum n (fun j => half j i))).
    rewrite (sum_swap n n (fun i j => half j i)), <- sum_plus.
    apply sum_ext; intros i _; rewrite <- sum_plus, <- sum_scal.
    apply sum_ext; intros j _; unfold half; field; pose proof (V i); lra.
  rewrite <- sum_plus; apply sum_ext; intros i _; now rewrite <- sum_plus.
Qed.

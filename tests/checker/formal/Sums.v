(* Finite sums, and the inequality of Cauchy and Schwarz. *)
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

Lemma is_derive_sum n (f df : nat -> R -> R) s :
  (forall i, (i < n)%nat -> is_derive (f i) s (df i s)) ->
  is_derive (fun u => sum n (fun i => f i u)) s (sum n (fun i => df i s)).
Proof.
induction n as [|n IH]; intros H; simpl.
  exact (is_derive_const 0 s).
exact (is_derive_plus _ _ _ _ _ (IH (fun i Hi => H i ltac:(lia))) (H n ltac:(lia))).
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

(* The order of three factors in a double sum. *)
Lemma sum_product n m (a : nat -> R) (b : nat -> nat -> R) (c : nat -> R) :
  sum n (fun i => a i * sum m (fun j => b i j * c j))
  = sum m (fun j => sum n (fun i => a i * b i j) * c j).
Proof.
transitivity (sum n (fun i => sum m (fun j => a i * b i j * c j))).
  apply sum_ext; intros i _; rewrite <- sum_scal; apply sum_ext; intros j _; ring.
rewrite sum_swap; apply sum_ext; intros j _; rewrite Rmult_comm, <- sum_scal.
apply sum_ext; intros i _; ring.
Qed.

Lemma cauchy_schwarz n (a z : nat -> R) :
  Rsqr (sum n (fun i => a i * z i)) <= sum n (fun i => a i * a i) * sum n (fun i => z i * z i).
Proof.
induction n as [|n IH]; simpl; [rewrite Rsqr_0; lra|].
set (s := sum n (fun i => a i * z i)) in *.
set (A := sum n (fun i => a i * a i)) in *; set (Z := sum n (fun i => z i * z i)) in *.
assert (A0 : 0 <= A) by (apply sum_nonneg; intros; apply Rle_0_sqr).
assert (Z0 : 0 <= Z) by (apply sum_nonneg; intros; apply Rle_0_sqr).
set (x := a n); set (y := z n).
assert (P : 2 * (s * (x * y)) <= A * (y * y) + x * x * Z).
  apply Rsqr_incr_0_var.
  - apply Rle_trans with (4 * (A * Z) * (Rsqr (x * y))).
      replace (Rsqr (2 * (s * (x * y)))) with (4 * Rsqr s * Rsqr (x * y)) by (unfold Rsqr; ring).
      apply Rmult_le_compat_r; [apply Rle_0_sqr | lra].
    replace (Rsqr (A * (y * y) + x * x * Z))
      with (4 * (A * Z) * Rsqr (x * y) + Rsqr (A * (y * y) - x * x * Z)) by (unfold Rsqr; ring).
    pose proof (Rle_0_sqr (A * (y * y) - x * x * Z)); lra.
  - apply Rplus_le_le_0_compat; apply Rmult_le_pos; try easy; apply Rle_0_sqr.
replace (Rsqr (s + x * y)) with (Rsqr s + 2 * (s * (x * y)) + x * x * (y * y)) by (unfold Rsqr; ring).
replace ((A + x * x) * (Z + y * y)) with (A * Z + (A * (y * y) + x * x * Z) + x * x * (y * y)) by ring.
lra.
Qed.

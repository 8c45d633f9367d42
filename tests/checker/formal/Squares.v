(* A quadratic form is nonnegative if completing squares, in intervals, meets only positive numbers. *)
From Coq Require Import Reals ZArith List Bool Lra Lia.
From Interval Require Import Xreal Interval.Interval.
Require Import Sums Intervals.
Import ListNotations.
Open Scope R_scope.

Definition form (n : nat) (K : nat -> nat -> R) (z : nat -> R) :=
  sum n (fun i => z i * sum n (fun j => K i j * z j)).
(* The rest of a form after the square with the last variable is subtracted. *)
Definition rest (m : nat) (K : nat -> nat -> R) i j := K i j - K i m * K j m / K m m.

Lemma form_rest n K z :
  (forall i j, K i j = K j i) -> 0 < K n n ->
  form (S n) K z = form n (rest n K) z
    + K n n * (z n + sum n (fun i => K i n * z i) / K n n) ^ 2.
Proof.
intros Sym P.
set (b := sum n (fun i => K i n * z i)).
assert (E : form n (rest n K) z = form n K z - b * b / K n n).
  unfold form.
  transitivity (sum n (fun i => z i * sum n (fun j => K i j * z j) + - (b / K n n) * (K i n * z i))).
    apply sum_ext; intros i _.
    replace (sum n (fun j => rest n K i j * z j))
      with (sum n (fun j => K i j * z j) + - (K i n / K n n) * b); [field; lra|].
    unfold b; rewrite <- sum_scal, <- sum_plus; apply sum_ext; intros j _; unfold rest; field; lra.
  rewrite sum_plus, sum_scal; fold b; field; lra.
rewrite E; unfold form at 1; simpl.
replace (sum n (fun i => z i * (sum n (fun j => K i j * z j) + K i n * z n)))
  with (form n K z + z n * b).
  replace (sum n (fun j => K n j * z j)) with b; [field; lra|].
  apply sum_ext; intros j _; now rewrite Sym.
unfold form, b; rewrite <- sum_scal, <- sum_plus; apply sum_ext; intros i _; ring.
Qed.

Definition entry (K : list (list I.type)) i j := nth j (nth i K nil) I.nai.
Definition table (n : nat) (f : nat -> nat -> I.type) := map (fun i => map (f i) (seq 0 n)) (seq 0 n).
Fixpoint nonnegative (n : nat) (K : list (list I.type)) : bool :=
  match n with
  | O => true
  | S m => let d := entry K m m in
    is_positive d && nonnegative m (table m (fun i j =>
      I.sub prec (entry K i j) (I.div prec (I.mul prec (entry K i m) (entry K j m)) d)))
  end.

Lemma entry_table n f i j : (i < n)%nat -> (j < n)%nat -> entry (table n f) i j = f i j.
Proof.
intros Hi Hj; unfold entry, table.
rewrite (nth_indep _ nil (map (f O) (seq 0 n))) by now rewrite map_length, seq_length.
rewrite (map_nth (fun i => map (f i) (seq 0 n))), seq_nth by easy; simpl.
rewrite (nth_indep _ I.nai (f i O)) by now rewrite map_length, seq_length.
now rewrite map_nth, seq_nth.
Qed.

Theorem nonnegative_correct n : forall K M z,
  nonnegative n M = true -> (forall i j, K i j = K j i) ->
  (forall i j, (i < n)%nat -> (j < n)%nat -> K i j \in entry M i j) -> 0 <= form n K z.
Proof.
induction n as [|n IH]; intros K M z C Sym In; [unfold form; simpl; lra|].
cbn [nonnegative] in C; apply andb_true_iff in C; destruct C as [P C].
assert (P' : 0 < K n n) by (apply positive with (1 := P), In; lia).
rewrite form_rest by easy.
apply Rplus_le_le_0_compat; [|apply Rmult_le_pos; [lra | apply pow2_ge_0]].
apply IH with (1 := C).
- intros i j; unfold rest; rewrite Sym; field; lra.
- intros i j Hi Hj; rewrite entry_table by easy; unfold rest.
  apply sub_in; [apply In; lia|].
  apply div_in; [lra | apply mul_in; apply In; lia | apply In; lia].
Qed.

(* Theorem 1 for the first second of maneuver 3. *)
From Coq Require Import Reals ZArith List Lra Lia.
Require Import Enclosure Equations Certificate.
Open Scope R_scope.

(* The hypotheses, by computation in intervals. *)
Lemma checked : check equations integers start pieces = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

(* A motion of the bicycle that begins as maneuver 3 does is, as long as it exists, within 1e-8 of
   the candidate in each of its seven state variables. *)
Theorem maneuver_3 (x : nat -> R -> R) (until : R) :
  motion equations integers x until -> begins start x -> near_candidate x until pieces.
Proof. exact (enclosed equations integers start pieces x until checked). Qed.

(* The pieces cover a second: at each time one of them is as near. *)
Corollary first_second (x : nat -> R -> R) :
  motion equations integers x 1 -> begins start x ->
  forall t, 0 <= t <= 1 -> exists p s, In p pieces /\ 0 <= s <= step /\
  forall i, (i < count)%nat -> Rabs (x i t - candidate p i s) <= error.
Proof.
intros M B t Ht.
assert (K : exists k, (k < length pieces)%nat /\ INR k * step <= t <= INR k * step + step).
  assert (C : forall n, t <= INR n * step -> (0 < n)%nat ->
    exists k, (k < n)%nat /\ INR k * step <= t <= INR k * step + step).
    induction n as [|n IH]; intros U P; [lia|].
    rewrite S_INR in U.
    destruct (Rle_dec t (INR n * step)) as [L|L].
      destruct n as [|n]; [exists O; simpl in *; split; [lia | unfold step in *; lra]|].
      destruct (IH L ltac:(lia)) as [k [Hk E]]; exists k; split; [lia | exact E].
    exists n; split; [lia | lra].
  apply C; [unfold step; simpl; lra | simpl; lia].
destruct K as [k [Hk E]].
destruct (nth_error pieces k) as [p|] eqn:P; [|now apply nth_error_None in P; apply Nat.lt_nge in Hk].
exists p, (t - INR k * step); split; [now apply nth_error_In with k|]; split; [lra|].
intros i Hi; replace t with (INR k * step + (t - INR k * step)) at 1 by ring.
apply (maneuver_3 x 1 M B k p P); [lra | lra | exact Hi].
Qed.

Print Assumptions first_second.

(* Theorem 1 for maneuver 1, ten seconds. *)
From Coq Require Import Reals QArith Qreals ZArith List.
Require Import Existence Readable Reading Equations Certificate1.
Require Checked1_0 Checked1_1 Checked1_2 Checked1_3 Checked1_4.
Import ListNotations.
Open Scope R_scope.

Definition pieces : list piece :=
  concat (map members [block_0; block_1; block_2; block_3; block_4]).

(* Upright and straight at 4 m/s, with a roll rate of 0.05 rad/s; rear wheel spin 40/3 rad/s *)
Lemma initial_state : start = [(0, 1); (0, 1); (0, 1); (1, 20); (0, 1); (40, 3); (0, 1)]%Z.
Proof. reflexivity. Qed.

(* How near the motion is to its polynomials, in rad or rad/s *)
Definition accuracy : R := 2 / 10000000000000.

Lemma claimed : Q2R (claim certified) = accuracy.
Proof. unfold accuracy, Q2R; simpl; field. Qed.

Lemma begun : check_start start certified block_0 = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

Lemma all_blocks : all_checked equations integers certified
  [block_0; block_1; block_2; block_3; block_4].
Proof.
refine (conj Checked1_0.checked (conj _ (conj _ (conj Checked1_1.checked (conj _ (conj _
  (conj Checked1_2.checked (conj _ (conj _ (conj Checked1_3.checked (conj _ (conj _
  (conj Checked1_4.checked (conj _ (conj _ Logic.I)))))))))))))));
  try discriminate; apply entry_nonneg; vm_cast_no_check (eq_refl true).
Qed.

(* A motion of the bicycle that begins as maneuver 1 does is within 2e-13 of the candidate in each of
   its seven state variables. *)
Theorem maneuver_1 (x : nat -> R -> R) (until : R) :
  motion equations integers x until -> begins start x -> near_candidate x until pieces accuracy.
Proof. rewrite <- claimed; exact (enclosed _ _ _ _ _ _ x until begun all_blocks). Qed.

(* There is exactly one such motion for ten seconds: shorter ones agree with it, too. At each time
   one of the polynomials is as near. *)
Theorem ten_seconds : exists x, motion equations integers x 10 /\ begins start x /\
  (forall y until, until <= 10 -> motion equations integers y until -> begins start y ->
   forall t, 0 <= t <= until -> forall i, (i < count)%nat -> y i t = x i t) /\
  forall t, 0 <= t <= 10 -> exists p s, In p pieces /\ - half <= s <= half /\
  forall i, (i < count)%nat -> Rabs (x i t - candidate p i s) <= accuracy.
Proof.
rewrite <- claimed; exact (one_motion _ _ _ _ _ _ begun all_blocks ltac:(vm_compute; reflexivity)).
Qed.

(* The same for the formulas of Readable.v *)
Theorem ten_seconds_readable : exists x, obeys x 10 /\ begins start x /\
  (forall y until, until <= 10 -> obeys y until -> begins start y ->
   forall t, 0 <= t <= until -> forall i, (i < count)%nat -> y i t = x i t) /\
  forall t, 0 <= t <= 10 -> exists p s, In p pieces /\ - half <= s <= half /\
  forall i, (i < count)%nat -> Rabs (x i t - candidate p i s) <= accuracy.
Proof. exact (readable_form start _ ten_seconds). Qed.

Print Assumptions ten_seconds_readable.

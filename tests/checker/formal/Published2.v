(* The published text of maneuver 2. *)
From Coq Require Import Reals List Lra.
Require Import Checks Equations Certificate2 Maneuver2 Lines Text.
Open Scope R_scope.

Lemma line_count : length lines = 1001%nat.
Proof. vm_compute; reflexivity. Qed.

Lemma compared : check_text pieces 2 lines = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

(* In rad or rad/s *)
Definition text_accuracy : R := 5 / 100000000000000.

(* A motion of the bicycle that begins as maneuver 2 does is within 5e-14 of the text's angles and
   rates, and within 1.5e-14 m/s of its forward speeds. *)
Theorem published_2 (x : nat -> R -> R) (until : R) :
  motion equations integers x until -> begins start x -> near_text x until lines 2 text_accuracy.
Proof.
intros M B; apply (published x until pieces 2 lines accuracy); [|exact compared|].
  unfold accuracy, reading, text_accuracy; lra.
exact (maneuver_2 x until M B).
Qed.

(* There is exactly one such motion for ten seconds: shorter ones agree with it, too. Each line of
   the text is as near to it. *)
Theorem published_ten_seconds : exists x, motion equations integers x 10 /\ begins start x /\
  (forall y until, until <= 10 -> motion equations integers y until -> begins start y ->
   forall t, 0 <= t <= until -> forall i, (i < count)%nat -> y i t = x i t) /\
  near_text x 10 lines 2 text_accuracy.
Proof.
destruct ten_seconds as [x [M [B [Unique _]]]].
exact (ex_intro _ x (conj M (conj B (conj Unique (published_2 x 10 M B))))).
Qed.

Print Assumptions published_ten_seconds.

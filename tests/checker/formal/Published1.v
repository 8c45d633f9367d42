(* The published text of maneuver 1. *)
From Coq Require Import Reals List.
Require Import Checks Equations Certificate1 Maneuver1 Lines Text.
Open Scope R_scope.

Lemma line_count : length lines = 1001%nat.
Proof. vm_compute; reflexivity. Qed.

Lemma compared : check_text pieces 1 lines = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

(* A motion of the bicycle that begins as maneuver 1 does is, as long as it exists, within 1.1e-8 of
   the text's angles and rates, and within 3.3e-9 m/s of its forward speeds. *)
Theorem published_1 (x : nat -> R -> R) (until : R) :
  motion equations integers x until -> begins start x -> near_text x until lines 1.
Proof. intros M B; exact (published x until pieces 1 lines compared (maneuver_1 x until M B)). Qed.

Print Assumptions published_1.

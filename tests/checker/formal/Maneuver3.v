(* Theorem 1 for the first second of maneuver 3. *)
From Coq Require Import Reals ZArith List.
Require Import Enclosure Equations Certificate.
Open Scope R_scope.

(* The hypotheses, by computation in intervals. *)
Lemma checked : check equations integers start pieces = true.
Proof. Time vm_cast_no_check (eq_refl true). Time Qed.

Lemma second : INR (length pieces) * step = 1.
Proof. unfold step; simpl; field. Qed.

(* A motion of the bicycle that begins as maneuver 3 does is, as long as it exists, for a second,
   within 1e-8 of the candidate in each of its seven state variables. *)
Theorem maneuver_3 (x : nat -> R -> R) (until : R) :
  motion equations integers x until -> begins start x -> near_candidate x until pieces.
Proof. exact (enclosed equations integers start pieces x until checked). Qed.

Print Assumptions maneuver_3.

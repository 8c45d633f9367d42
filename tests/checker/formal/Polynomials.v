(* Polynomials with coefficients over a power of two, as the certificates contain them. *)
From Coq Require Import Reals ZArith List Lra Lia.
From Coquelicot Require Import Coquelicot.
Import ListNotations.
Open Scope R_scope.

(* n over 2 to the power of bits *)
Definition over (n : Z) (bits : Z) : R := IZR n / IZR (2 ^ bits).

(* Coefficients are integers over 2 to this power, the constant one first. *)
Definition grid : Z := 80.

Fixpoint polynomial (c : list Z) (s : R) : R :=
  match c with nil => 0 | a :: c => over a grid + s * polynomial c s end.
Fixpoint slope_of (c : list Z) (s : R) : R :=
  match c with nil => 0 | a :: c => polynomial c s + s * slope_of c s end.

Lemma power_nonzero b : (0 <= b)%Z -> IZR (2 ^ b) <> 0.
Proof. intros H; apply IZR_neq, Z.pow_nonzero; lia. Qed.

Lemma is_derive_polynomial c s : is_derive (polynomial c) s (slope_of c s).
Proof.
induction c as [|a c IH]; simpl; [exact (is_derive_const 0 s)|].
replace (polynomial c s + s * slope_of c s) with (0 + (1 * polynomial c s + s * slope_of c s)) by ring.
apply (is_derive_plus (fun _ => over a grid) (fun s => s * polynomial c s)).
  apply (is_derive_const (over a grid)).
apply (is_derive_mult (fun s => s) (polynomial c)); [apply (is_derive_id s) | exact IH | intros; apply Rmult_comm].
Qed.

(* Taylor models of CoqInterval at one time: the values that they may have there. *)
From Coq Require Import Reals ZArith List Lra Lia.
From Interval Require Import Xreal Interval.Interval Taylor_model_sharp.
From Interval Require Import Eval.Tree Eval.Prog Eval.Eval.
Require Import Intervals.
Import ListNotations.
Open Scope R_scope.

Module TV := A.TaylorValuator.
Module TM := TV.TM.

(* The value of a model over a span, by Horner's rule. TM.eval completes a square instead, which
   divides by the second coefficient, and that may nearly vanish. *)
Definition value (span : I.type) (m : TM.T) (s : I.type) : I.type :=
  match m with
  | TM.Const c => c
  | TM.Var => s
  | TM.Tm r =>
    I.add prec (TM.Pol.horner prec (approx r) (I.sub prec s (A.J.midpoint span))) (error r)
  end.

Section Time.
Variable u : TM.U.
Variable span : I.type.
Variable time : R.
Hypothesis inside : time \in span.

(* The model approximates a function that has this value at the time. *)
Definition reads (m : TM.T) (v : R) : Prop :=
  exists f, TM.approximates span m f /\ f time = Xreal v.

Lemma span_not_empty : not_empty (I.convert span).
Proof. now exists time. Qed.

Lemma value_in m v s : reads m v -> time \in s -> v \in value span m s.
Proof.
intros [f [Ap Ft]] S; specialize (Ap span_not_empty).
destruct m as [c| |r]; cbn [value].
- destruct Ap as [->|[y Y E]]; [easy|].
  now rewrite <- Ft, (E time inside).
- specialize (Ap time inside); now replace v with time by congruence.
- destruct Ap as [_ _ _ _ [Q HQ HE]].
  specialize (HE time inside); rewrite Ft in HE; simpl proj_val in HE.
  set (mid := proj_val _) in HE.
  replace v with (Datatypes.PolR.horner tt Q (time - mid) + (v - Datatypes.PolR.horner tt Q (time - mid)))
    by ring.
  apply add_in; [|easy].
  apply TM.Pol.horner_correct; [easy|].
  apply sub_in; [easy | apply A.J.contains_midpoint, span_not_empty].
Qed.

Lemma const_reads v c : v \in c -> reads (TM.const c) v.
Proof. intros V; exists (fun _ => Xreal v); split; [now apply TM.const_correct | easy]. Qed.
Lemma add_reads x y a b : reads a x -> reads b y -> reads (TM.add u span a b) (x + y).
Proof.
intros [f [F X]] [g [G Y]]; exists (fun t => Xadd (f t) (g t)).
split; [now apply TM.add_correct | now rewrite X, Y].
Qed.
Lemma sub_reads x y a b : reads a x -> reads b y -> reads (TM.sub u span a b) (x - y).
Proof.
intros [f [F X]] [g [G Y]]; exists (fun t => Xsub (f t) (g t)).
split; [now apply TM.sub_correct | now rewrite X, Y].
Qed.
Lemma mul_reads x y a b : reads a x -> reads b y -> reads (TM.mul u span a b) (x * y).
Proof.
intros [f [F X]] [g [G Y]]; exists (fun t => Xmul (f t) (g t)).
split; [now apply TM.mul_correct | now rewrite X, Y].
Qed.
Lemma opp_reads x a : reads a x -> reads (TM.opp u span a) (- x).
Proof.
intros [f [F X]]; exists (fun t => Xneg (f t)); split; [now apply TM.opp_correct | now rewrite X].
Qed.
Lemma sin_reads x a : reads a x -> reads (TM.sin u span a) (sin x).
Proof.
intros [f [F X]]; exists (fun t => Xsin (f t)); split; [now apply TM.sin_correct | now rewrite X].
Qed.
Lemma cos_reads x a : reads a x -> reads (TM.cos u span a) (cos x).
Proof.
intros [f [F X]]; exists (fun t => Xcos (f t)); split; [now apply TM.cos_correct | now rewrite X].
Qed.
Lemma inv_reads x a : x <> 0 -> reads a x -> reads (TM.inv u span a) (/ x).
Proof.
intros N [f [F X]]; exists (fun t => Xinv (f t)); split; [now apply TM.inv_correct|].
rewrite X; simpl; unfold Xinv'; now rewrite is_zero_false.
Qed.

End Time.

(* How far the derivatives of polynomials are from the rates of a program at one time, in intervals
   of 100 bits. *)
From Coq Require Import Reals ZArith List Bool Lra Lia.
From Interval Require Import Xreal Interval.Interval Basic Float Float_full Specific_bigint Specific_ops.
From Interval Require Import Eval.Tree Eval.Prog Eval.Eval.
Require Import Intervals Polynomials.
Import ListNotations.
Open Scope R_scope.

Module F := SpecificFloat BigIntRadix2.
Module W := FloatIntervalFull F.
Module WA := IntervalAlgos W.

Definition wide := W.F.PtoP 100.
Notation "x \within i" := (contains (W.convert i) (Xreal x)) (at level 70).

Definition wide_integer (n : Z) : W.type := W.fromZ wide n.
Definition wide_fraction (n d : Z) : W.type := W.div wide (wide_integer n) (wide_integer d).

Lemma fraction_within n d : d <> 0%Z -> IZR n / IZR d \within wide_fraction n d.
Proof.
intros N; assert (E : Xdiv (Xreal (IZR n)) (Xreal (IZR d)) = Xreal (IZR n / IZR d)).
  simpl; unfold Xdiv'; now rewrite is_zero_false by now apply IZR_neq.
rewrite <- E; exact (W.div_correct wide _ _ _ _ (W.fromZ_correct wide n) (W.fromZ_correct wide d)).
Qed.

(* A polynomial and its derivative, by Horner's rule *)
Definition wide_coefficients (c : list Z) : list W.type :=
  map (fun a => wide_fraction a (2 ^ grid)) c.
Fixpoint wide_polynomial (c : list W.type) (s : W.type) : W.type :=
  match c with nil => W.zero | a :: c => W.add wide a (W.mul wide s (wide_polynomial c s)) end.
Fixpoint wide_slope (c : list W.type) (s : W.type) : W.type :=
  match c with
  | nil => W.zero
  | a :: c => W.add wide (wide_polynomial c s) (W.mul wide s (wide_slope c s))
  end.

Lemma zero_within : 0 \within W.zero.
Proof. rewrite W.zero_correct; simpl; lra. Qed.

Lemma polynomial_within c s i :
  s \within i -> polynomial c s \within wide_polynomial (wide_coefficients c) i.
Proof.
intros S; induction c as [|a c IH]; [exact zero_within|].
cbn [polynomial slope_of wide_polynomial wide_slope wide_coefficients map].
apply (W.add_correct wide _ _ (Xreal (over a grid)) (Xreal (s * polynomial c s))).
  now apply fraction_within.
exact (W.mul_correct wide _ _ _ _ S IH).
Qed.

Lemma slope_within c s i : s \within i -> slope_of c s \within wide_slope (wide_coefficients c) i.
Proof.
intros S; induction c as [|a c IH]; [exact zero_within|].
cbn [polynomial slope_of wide_polynomial wide_slope wide_coefficients map].
apply (W.add_correct wide _ _ (Xreal (polynomial c s)) (Xreal (s * slope_of c s))).
  now apply polynomial_within.
exact (W.mul_correct wide _ _ _ _ S IH).
Qed.

(* An interval of binary64 that contains one of 100 bits *)
Definition number_of (f : float F.radix) : I.type :=
  match f with
  | Basic.Fnan => I.nai
  | Basic.Fzero => I.zero
  | Basic.Float s m e =>
    let n := if s then Zneg m else Zpos m in
    match e with
    | Z0 => integer n
    | Zpos e => integer (n * 2 ^ Zpos e)
    | Zneg e => I.div prec (integer n) (integer (2 ^ Zpos e))
    end
  end.
Definition narrow (a : W.type) : I.type :=
  match a with
  | Float.Inan => I.nai
  | Float.Ibnd l u => I.join (number_of (F.toF l)) (number_of (F.toF u))
  end.

Lemma number_of_in (f : float F.radix) x : FtoX f = Xreal x -> x \in number_of f.
Proof.
destruct f as [| |s m e]; intros E; [discriminate E | injection E as <-; apply zero_in |].
unfold FtoX in E; injection E as <-; unfold FtoR, number_of; destruct e as [|e|e].
- apply integer_in.
- apply integer_in.
- apply div_in; [apply IZR_neq; change (2 ^ Z.pos e <> 0)%Z; lia | apply integer_in | apply integer_in].
Qed.

Lemma number_of_nan (f : float F.radix) x : FtoX f = Xnan -> x \in number_of f.
Proof. now destruct f. Qed.

Lemma narrow_in x a : x \within a -> x \in narrow a.
Proof.
destruct a as [|l u]; [easy|]; cbn [narrow]; unfold W.convert.
destruct (_ && _); [|simpl; lra].
change (W.F.toX l) with (FtoX (F.toF l)); change (W.F.toX u) with (FtoX (F.toF u)).
destruct (FtoX (F.toF l)) as [|v] eqn:El.
  intros _; apply I.join_correct; left; now apply number_of_nan.
destruct (FtoX (F.toF u)) as [|w] eqn:Eu.
  intros _; apply I.join_correct; right; now apply number_of_nan.
intros [L U]; apply between_in with v w; [| | lra]; apply I.join_correct; [left | right];
  now apply number_of_in.
Qed.

Section Program.
Variable program : list term.
Variable integers : list Z.

Definition wide_constants : list W.type := map wide_integer integers ++ [W.pi wide].
(* Rates of the state that polynomials have at a time *)
Definition wide_rates (rows : list (list W.type)) (s : W.type) : list W.type :=
  WA.BndValuator.eval wide program (map (fun c => wide_polynomial c s) rows ++ wide_constants).
Definition wide_defect (rates : list W.type) (c : list W.type) (s : W.type) (i : nat) : I.type :=
  narrow (W.sub wide (wide_slope c s) (nth i rates W.nai)).

Lemma all_within a x : Forall2 (fun a x => x \within a) a x -> WA.contains_all a x.
Proof.
intros F; split; [induction F; simpl; congruence|].
induction F as [|b y a x Y _ IH]; intros n; destruct n as [|n]; try easy; exact (IH n).
Qed.

Lemma defect_within rows c s i n : s \within i ->
  slope_of c s - nth n (eval_real program (map (fun c => polynomial c s) rows ++ map IZR integers ++ [PI])) 0
  \in wide_defect (wide_rates (map wide_coefficients rows) i) (wide_coefficients c) i n.
Proof.
intros S; apply narrow_in.
apply (W.sub_correct wide _ _ (Xreal _) (Xreal _)); [now apply slope_within|].
apply WA.BndValuator.eval_correct', all_within; rewrite map_map.
apply Forall2_app; [|apply Forall2_app].
- induction rows; constructor; [now apply polynomial_within | assumption].
- induction integers; constructor; [apply W.fromZ_correct | assumption].
- constructor; [apply W.pi_correct | constructor].
Qed.
End Program.

(* Intervals of binary64: what is in them, from what is in their operands. *)
From Coq Require Import Reals ZArith List Lra Lia.
From Coquelicot Require Import Coquelicot.
From Interval Require Import Xreal Interval.Interval Float_full Tactic_float.
From Interval Require Import Eval.Tree Eval.Prog Eval.Eval.
Require Import Sums.
Import ListNotations.
Open Scope R_scope.

Module I := FloatIntervalFull Tactic_float.Float.
Module A := IntervalAlgos I.

Definition prec := I.F.PtoP 53.
Notation "x \in i" := (contains (I.convert i) (Xreal x)) (at level 70).

Definition integer (n : Z) : I.type := I.fromZ prec n.

Lemma integer_in n : IZR n \in integer n.
Proof. apply I.fromZ_correct. Qed.
Lemma zero_in : 0 \in I.zero.
Proof. rewrite I.zero_correct; simpl; lra. Qed.
Lemma add_in x y a b : x \in a -> y \in b -> x + y \in I.add prec a b.
Proof. intros X Y; exact (I.add_correct prec _ _ _ _ X Y). Qed.
Lemma sub_in x y a b : x \in a -> y \in b -> x - y \in I.sub prec a b.
Proof. intros X Y; exact (I.sub_correct prec _ _ _ _ X Y). Qed.
Lemma mul_in x y a b : x \in a -> y \in b -> x * y \in I.mul prec a b.
Proof. intros X Y; exact (I.mul_correct prec _ _ _ _ X Y). Qed.
Lemma neg_in x a : x \in a -> - x \in I.neg a.
Proof. intros X; exact (I.neg_correct _ _ X). Qed.
Lemma exp_in x a : x \in a -> exp x \in I.exp prec a.
Proof. intros X; exact (I.exp_correct prec _ _ X). Qed.
Lemma div_in x y a b : y <> 0 -> x \in a -> y \in b -> x / y \in I.div prec a b.
Proof.
intros N X Y; generalize (I.div_correct prec _ _ _ _ X Y); simpl; unfold Xdiv'.
destruct (is_zero_spec y); [easy | trivial].
Qed.

Definition is_positive (a : I.type) : bool := match I.sign_strict a with Xgt => true | _ => false end.
Definition is_nonzero (a : I.type) : bool :=
  match I.sign_strict a with Xgt | Xlt => true | _ => false end.

Lemma positive x a : is_positive a = true -> x \in a -> 0 < x.
Proof.
unfold is_positive; intros P X; generalize (I.sign_strict_correct a).
destruct (I.sign_strict a); try easy; intros H; now destruct (H _ X).
Qed.
Lemma nonzero x a : is_nonzero a = true -> x \in a -> x <> 0.
Proof.
unfold is_nonzero; intros P X; generalize (I.sign_strict_correct a).
destruct (I.sign_strict a); try easy; intros H; destruct (H _ X) as [_ S]; simpl in S; lra.
Qed.

Fixpoint interval_sum (n : nat) (f : nat -> I.type) : I.type :=
  match n with O => I.zero | S m => I.add prec (interval_sum m f) (f m) end.

Lemma sum_in n f g : (forall i, (i < n)%nat -> f i \in g i) -> sum n f \in interval_sum n g.
Proof.
induction n as [|n IH]; intros H; simpl; [apply zero_in | apply add_in; auto].
Qed.

Lemma sqr_in x a : x \in a -> x * x \in I.sqr prec a.
Proof. intros X; exact (I.sqr_correct prec _ _ X). Qed.
Lemma sqrt_in x a : x \in a -> sqrt x \in I.sqrt prec a.
Proof. intros X; exact (A.J.sqrt_correct prec _ _ X). Qed.

Lemma between_in a x y z : x \in a -> y \in a -> x <= z <= y -> z \in a.
Proof. intros X Y Z; exact (contains_connected (I.convert a) x y X Y z Z). Qed.

Lemma less_by a b x y : a \in x -> b \in y -> is_positive (I.sub prec x y) = true -> b < a.
Proof. intros X Y P; generalize (positive _ _ P (sub_in _ _ _ _ X Y)); lra. Qed.

(* The numbers from n to m over d *)
Definition stretch (n m d : Z) : I.type :=
  I.join (I.div prec (integer n) (integer d)) (I.div prec (integer m) (integer d)).

Lemma stretch_in n m d x : d <> 0%Z -> IZR n / IZR d <= x <= IZR m / IZR d -> x \in stretch n m d.
Proof.
intros D; apply IZR_neq in D.
apply between_in; apply I.join_correct; [left | right]; apply div_in; try easy; apply integer_in.
Qed.

(* Programs of CoqInterval on boxes: how far apart two values are, by interval slopes. *)
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
Lemma zero_only x : x \in I.zero -> x = 0.
Proof. rewrite I.zero_correct; simpl; lra. Qed.
Lemma add_in x y a b : x \in a -> y \in b -> x + y \in I.add prec a b.
Proof. intros X Y; exact (I.add_correct prec _ _ _ _ X Y). Qed.
Lemma sub_in x y a b : x \in a -> y \in b -> x - y \in I.sub prec a b.
Proof. intros X Y; exact (I.sub_correct prec _ _ _ _ X Y). Qed.
Lemma mul_in x y a b : x \in a -> y \in b -> x * y \in I.mul prec a b.
Proof. intros X Y; exact (I.mul_correct prec _ _ _ _ X Y). Qed.
Lemma neg_in x a : x \in a -> - x \in I.neg a.
Proof. intros X; exact (I.neg_correct _ _ X). Qed.
Lemma abs_in x a : x \in a -> Rabs x \in I.abs a.
Proof. intros X; exact (I.abs_correct _ _ X). Qed.
Lemma sin_in x a : x \in a -> sin x \in I.sin prec a.
Proof. intros X; exact (I.sin_correct prec _ _ X). Qed.
Lemma cos_in x a : x \in a -> cos x \in I.cos prec a.
Proof. intros X; exact (I.cos_correct prec _ _ X). Qed.
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

(* A value with its slopes; none where it is not known to have any. Missing slopes are zero. *)
Definition sloped := option (I.type * list I.type).

Definition within (g : nat -> R) (l : list I.type) := forall j, g j \in nth j l I.zero.

Fixpoint add_slopes (a b : list I.type) : list I.type :=
  match a, b with
  | nil, _ => b
  | _, nil => a
  | x :: a, y :: b => I.add prec x y :: add_slopes a b
  end.
Definition scale (c : I.type) (a : list I.type) := map (fun x => I.mul prec x c) a.

Lemma add_slopes_in f g a b :
  within f a -> within g b -> within (fun j => f j + g j) (add_slopes a b).
Proof.
revert f g b; induction a as [|x a IH]; intros f g b F G j.
  replace (f j) with 0; [rewrite Rplus_0_l; apply G|].
  symmetry; apply zero_only; generalize (F j); now destruct j.
destruct b as [|y b].
  replace (g j) with 0; [rewrite Rplus_0_r; apply F|].
  symmetry; apply zero_only; generalize (G j); now destruct j.
destruct j as [|j]; simpl.
  exact (add_in _ _ _ _ (F O) (G O)).
exact (IH (fun j => f (S j)) (fun j => g (S j)) b (fun j => F (S j)) (fun j => G (S j)) j).
Qed.

Lemma scale_in f c x a : within f a -> x \in c -> within (fun j => f j * x) (scale c a).
Proof.
revert f; induction a as [|y a IH]; intros f F X j.
  replace (f j) with 0; [rewrite Rmult_0_l; destruct j; apply zero_in|].
  symmetry; apply zero_only; generalize (F j); now destruct j.
destruct j as [|j]; simpl; [exact (mul_in _ _ _ _ (F O) X)|].
exact (IH (fun j => f (S j)) (fun j => F (S j)) X j).
Qed.

Definition sloped_unary (o : unary_op) (a : sloped) : sloped :=
  match o, a with
  | Neg, Some (x, p) => Some (I.neg x, scale (integer (-1)) p)
  | Sin, Some (x, p) => Some (I.sin prec x, scale (I.cos prec x) p)
  | Cos, Some (x, p) => Some (I.cos prec x, scale (I.neg (I.sin prec x)) p)
  | _, _ => None
  end.

Definition sloped_binary (o : binary_op) (a b : sloped) : sloped :=
  match a, b with
  | Some (x, p), Some (y, q) =>
    match o with
    | Add => Some (I.add prec x y, add_slopes p q)
    | Sub => Some (I.sub prec x y, add_slopes p (scale (integer (-1)) q))
    | Mul => Some (I.mul prec x y, add_slopes (scale y p) (scale x q))
    | Div =>
      if is_nonzero y then
        let over := I.div prec (integer 1) y in
        let z := I.div prec x y in
        Some (z, scale over (add_slopes p (scale (I.neg z) q)))
      else None
    end
  | _, _ => None
  end.

Definition sloped_operations : operations sloped :=
  Build_operations (fun _ => None) sloped_unary sloped_binary (fun _ => Xund).

Section Segment.
Variable n : nat.
Variable e : nat -> R.

(* Along a segment in direction e a value stays in its interval, and its derivative is the sum of
   slopes in their intervals times e. *)
Definition moves (a : R -> R) (b : sloped) : Prop :=
  match b with
  | None => True
  | Some (x, p) => forall s, 0 <= s <= 1 ->
      a s \in x /\ exists g, within g p /\ is_derive a s (sum n (fun j => g j * e j))
  end.

Lemma moves_unary o a b :
  moves a b -> moves (fun s => unary real_operations o (a s)) (sloped_unary o b).
Proof.
destruct b as [[x p]|]; [|now destruct o].
destruct o; try easy; intros M s Hs; destruct (M s Hs) as [X [g [G D]]]; simpl.
- split; [now apply neg_in|].
  exists (fun j => g j * -1); split; [apply scale_in; [easy | apply integer_in]|].
  replace (sum n (fun j => g j * -1 * e j)) with (- sum n (fun j => g j * e j)).
    now apply (is_derive_opp a).
  replace (- sum n (fun j => g j * e j)) with (-1 * sum n (fun j => g j * e j)) by ring.
  rewrite <- sum_scal; apply sum_ext; intros; ring.
- split; [now apply cos_in|].
  exists (fun j => g j * - sin (a s)); split.
    apply scale_in; [easy | now apply neg_in, sin_in].
  replace (sum n (fun j => g j * - sin (a s) * e j)) with (sum n (fun j => g j * e j) * - sin (a s)).
    apply (is_derive_comp cos a); [apply is_derive_cos | exact D].
  rewrite Rmult_comm, <- sum_scal; apply sum_ext; intros; ring.
- split; [now apply sin_in|].
  exists (fun j => g j * cos (a s)); split.
    apply scale_in; [easy | now apply cos_in].
  replace (sum n (fun j => g j * cos (a s) * e j)) with (sum n (fun j => g j * e j) * cos (a s)).
    apply (is_derive_comp sin a); [apply is_derive_sin | exact D].
  rewrite Rmult_comm, <- sum_scal; apply sum_ext; intros; ring.
Qed.

Lemma moves_binary o a1 a2 b1 b2 :
  moves a1 b1 -> moves a2 b2 ->
  moves (fun s => binary real_operations o (a1 s) (a2 s)) (sloped_binary o b1 b2).
Proof.
destruct b1 as [[x p]|]; [|easy].
destruct b2 as [[y q]|]; [|easy].
intros M1 M2; destruct o; cbn [moves sloped_binary binary real_operations binary_real].
- intros s Hs; destruct (M1 s Hs) as [X [f [F D]]]; destruct (M2 s Hs) as [Y [g [G E]]].
  split; [now apply add_in|].
  exists (fun j => f j + g j); split; [now apply add_slopes_in|].
  replace (sum n (fun j => (f j + g j) * e j))
    with (sum n (fun j => f j * e j) + sum n (fun j => g j * e j)).
    exact (is_derive_plus a1 a2 s _ _ D E).
  rewrite <- sum_plus; apply sum_ext; intros; ring.
- intros s Hs; destruct (M1 s Hs) as [X [f [F D]]]; destruct (M2 s Hs) as [Y [g [G E]]].
  split; [now apply sub_in|].
  exists (fun j => f j + g j * -1); split.
    apply add_slopes_in; [easy | apply scale_in; [easy | apply integer_in]].
  replace (sum n (fun j => (f j + g j * -1) * e j))
    with (sum n (fun j => f j * e j) - sum n (fun j => g j * e j)).
    exact (is_derive_minus a1 a2 s _ _ D E).
  replace (sum n (fun j => f j * e j) - sum n (fun j => g j * e j))
    with (sum n (fun j => f j * e j) + -1 * sum n (fun j => g j * e j)) by ring.
  rewrite <- sum_scal, <- sum_plus; apply sum_ext; intros; ring.
- intros s Hs; destruct (M1 s Hs) as [X [f [F D]]]; destruct (M2 s Hs) as [Y [g [G E]]].
  split; [now apply mul_in|].
  exists (fun j => f j * a2 s + g j * a1 s); split.
    now apply add_slopes_in; apply scale_in.
  replace (sum n (fun j => (f j * a2 s + g j * a1 s) * e j))
    with (sum n (fun j => f j * e j) * a2 s + a1 s * sum n (fun j => g j * e j)).
    apply (is_derive_mult a1 a2 s _ _ D E); intros; apply Rmult_comm.
  rewrite (Rmult_comm _ (a2 s)), <- !sum_scal, <- sum_plus; apply sum_ext; intros; ring.
- destruct (is_nonzero y) eqn:N; [|easy].
  intros s Hs; destruct (M1 s Hs) as [X [f [F D]]]; destruct (M2 s Hs) as [Y [g [G E]]].
  assert (N' := nonzero _ _ N Y).
  assert (Q : a1 s / a2 s \in I.div prec x y) by now apply div_in.
  split; [easy|].
  exists (fun j => (f j + g j * - (a1 s / a2 s)) * (1 / a2 s)); split.
    apply scale_in.
      apply add_slopes_in; [easy | apply scale_in; [easy | now apply neg_in]].
    apply div_in; [easy | apply integer_in | easy].
  replace (sum n (fun j => (f j + g j * - (a1 s / a2 s)) * (1 / a2 s) * e j))
    with ((sum n (fun j => f j * e j) * a2 s - a1 s * sum n (fun j => g j * e j)) / a2 s ^ 2).
    apply (is_derive_div a1 a2); easy.
  replace ((sum n (fun j => f j * e j) * a2 s - a1 s * sum n (fun j => g j * e j)) / a2 s ^ 2)
    with (1 / a2 s * sum n (fun j => f j * e j)
          + - (a1 s / a2 s) * (1 / a2 s) * sum n (fun j => g j * e j)) by now field.
  rewrite <- !sum_scal, <- sum_plus; apply sum_ext; intros; ring.
Qed.

Lemma moves_program program (inputs : R -> list R) (boxes : list sloped) i :
  (forall j, moves (fun s => nth j (inputs s) 0) (nth j boxes None)) ->
  moves (fun s => nth i (eval_real program (inputs s)) 0)
        (nth i (eval_generic None sloped_operations program boxes) None).
Proof.
intros H; unfold eval_real.
apply (eval_inductive_prop_fun R sloped (fun a b => moves a b)); try easy.
- intros a b E [[x p]|] M; [|easy].
  intros s Hs; destruct (M s Hs) as [X [g [G D]]].
  rewrite <- E; split; [easy|]; exists g; split; [easy|].
  now apply (is_derive_ext a).
- apply moves_unary.
- apply moves_binary.
Qed.

(* The mean value theorem. *)
Lemma mean_value a x p :
  moves a (Some (x, p)) ->
  exists g, within g p /\ a 1 - a 0 = sum n (fun j => g j * e j).
Proof.
intros M.
destruct (MVT_gen a 0 1 (Derive a)) as [c [Hc E]].
- intros s Hs; rewrite Rmin_left, Rmax_right in Hs by lra.
  destruct (M s ltac:(lra)) as [_ [g [_ D]]]; apply Derive_correct; now exists (sum n (fun j => g j * e j)).
- intros s Hs; rewrite Rmin_left, Rmax_right in Hs by lra.
  destruct (M s ltac:(lra)) as [_ [g [_ D]]].
  apply continuity_pt_filterlim, (ex_derive_continuous a); now exists (sum n (fun j => g j * e j)).
- rewrite Rmin_left, Rmax_right in Hc by lra.
  destruct (M c Hc) as [_ [g [G D]]]; exists g; split; [easy|].
  rewrite E, (is_derive_unique _ _ _ D); ring.
Qed.

End Segment.

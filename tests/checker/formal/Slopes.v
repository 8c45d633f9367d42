(* Programs of CoqInterval at one time: how far apart two values are, by slopes. Values and slopes
   are Taylor models over a span of time. *)
From Coq Require Import Reals ZArith List Lra Lia.
From Coquelicot Require Import Coquelicot.
From Interval Require Import Xreal Interval.Interval.
From Interval Require Import Eval.Tree Eval.Prog Eval.Eval.
Require Import Sums Intervals Models.
Import ListNotations.
Open Scope R_scope.

Section Slopes.
Variable u : TM.U.
Variable span : I.type.

(* A value with its slopes; none where it is not known to have any. A missing slope is zero. *)
Definition slope := option TM.T.
Definition sloped := option (TM.T * list slope).

Definition add_slope (a b : slope) : slope :=
  match a, b with
  | None, _ => b
  | _, None => a
  | Some x, Some y => Some (TM.add u span x y)
  end.
Fixpoint add_slopes (a b : list slope) : list slope :=
  match a, b with
  | nil, _ => b
  | _, nil => a
  | x :: a, y :: b => add_slope x y :: add_slopes a b
  end.
Definition scale (c : TM.T) (a : list slope) := map (option_map (fun x => TM.mul u span x c)) a.
Definition opposite (a : list slope) := map (option_map (TM.opp u span)) a.

Definition sloped_unary (o : unary_op) (a : sloped) : sloped :=
  match o, a with
  | Neg, Some (x, p) => Some (TM.opp u span x, opposite p)
  | Sin, Some (x, p) => Some (TM.sin u span x, scale (TM.cos u span x) p)
  | Cos, Some (x, p) => Some (TM.cos u span x, scale (TM.opp u span (TM.sin u span x)) p)
  | _, _ => None
  end.

Definition sloped_binary (o : binary_op) (a b : sloped) : sloped :=
  match a, b with
  | Some (x, p), Some (y, q) =>
    match o with
    | Add => Some (TM.add u span x y, add_slopes p q)
    | Sub => Some (TM.sub u span x y, add_slopes p (opposite q))
    | Mul => Some (TM.mul u span x y, add_slopes (scale y p) (scale x q))
    | Div =>
      if is_nonzero (value span y span) then
        let inverse := TM.inv u span y in
        let z := TM.mul u span x inverse in
        Some (z, scale inverse (add_slopes p (scale (TM.opp u span z) q)))
      else None
    end
  | _, _ => None
  end.

Definition sloped_operations : operations sloped :=
  Build_operations (fun _ => None) sloped_unary sloped_binary (fun _ => Xund).

Section Time.
Variable time : R.
Hypothesis inside : time \in span.
Notation reads := (reads span time).

Definition slope_reads (s : slope) (g : R) := match s with None => g = 0 | Some m => reads m g end.
Definition within (g : nat -> R) (l : list slope) := forall j, slope_reads (nth j l None) (g j).

Lemma add_slopes_within a : forall f g b,
  within f a -> within g b -> within (fun j => f j + g j) (add_slopes a b).
Proof.
induction a as [|x a IH]; intros f g b F G j.
  replace (f j) with 0; [rewrite Rplus_0_l; apply G|].
  symmetry; generalize (F j); now destruct j.
destruct b as [|y b].
  replace (g j) with 0; [rewrite Rplus_0_r; apply F|].
  symmetry; generalize (G j); now destruct j.
destruct j as [|j]; simpl.
  generalize (F O) (G O); destruct x as [x|], y as [y|]; simpl; intros X Y.
  - now apply add_reads.
  - now rewrite Y, Rplus_0_r.
  - now rewrite X, Rplus_0_l.
  - lra.
exact (IH (fun j => f (S j)) (fun j => g (S j)) b (fun j => F (S j)) (fun j => G (S j)) j).
Qed.

Lemma map_within (h : TM.T -> TM.T) (k : R -> R) a f :
  k 0 = 0 -> (forall m x, reads m x -> reads (h m) (k x)) ->
  within f a -> within (fun j => k (f j)) (map (option_map h) a).
Proof.
intros K H; revert f; induction a as [|x a IH]; intros f F j.
  replace (f j) with 0; [destruct j; exact K|].
  symmetry; generalize (F j); now destruct j.
destruct j as [|j]; [|exact (IH (fun j => f (S j)) (fun j => F (S j)) j)].
generalize (F O); destruct x as [m|]; simpl; [apply H | now intros ->].
Qed.

Lemma scale_within f c x a : within f a -> reads c x -> within (fun j => f j * x) (scale c a).
Proof.
intros F X; apply (map_within _ (fun y => y * x)); [ring | | easy].
intros m y M; now apply mul_reads.
Qed.

Lemma opposite_within f a : within f a -> within (fun j => - f j) (opposite a).
Proof. intros F; apply (map_within _ Ropp); [ring | | easy]; intros m y; apply opp_reads. Qed.

Variable n : nat.
Variable e : nat -> R.

(* Along a segment in direction e the model reads a value, and its derivative is the sum of e times
   what the slopes read. *)
Definition moves (a : R -> R) (b : sloped) : Prop :=
  match b with
  | None => True
  | Some (x, p) => forall s, 0 <= s <= 1 ->
      reads x (a s) /\ exists g, within g p /\ is_derive a s (sum n (fun j => g j * e j))
  end.

Lemma moves_unary o a b :
  moves a b -> moves (fun s => unary real_operations o (a s)) (sloped_unary o b).
Proof.
destruct b as [[x p]|]; [|now destruct o].
destruct o; try easy; intros M s Hs; destruct (M s Hs) as [X [g [G D]]]; simpl.
- split; [now apply opp_reads|].
  exists (fun j => - g j); split; [now apply opposite_within|].
  replace (sum n (fun j => - g j * e j)) with (- sum n (fun j => g j * e j)).
    now apply (is_derive_opp a).
  replace (- sum n (fun j => g j * e j)) with (-1 * sum n (fun j => g j * e j)) by ring.
  rewrite <- sum_scal; apply sum_ext; intros; ring.
- split; [now apply cos_reads|].
  exists (fun j => g j * - sin (a s)); split.
    apply scale_within; [easy | now apply opp_reads, sin_reads].
  replace (sum n (fun j => g j * - sin (a s) * e j)) with (sum n (fun j => g j * e j) * - sin (a s)).
    apply (is_derive_comp cos a); [apply is_derive_cos | exact D].
  rewrite Rmult_comm, <- sum_scal; apply sum_ext; intros; ring.
- split; [now apply sin_reads|].
  exists (fun j => g j * cos (a s)); split.
    apply scale_within; [easy | now apply cos_reads].
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
  split; [now apply add_reads|].
  exists (fun j => f j + g j); split; [now apply add_slopes_within|].
  replace (sum n (fun j => (f j + g j) * e j))
    with (sum n (fun j => f j * e j) + sum n (fun j => g j * e j)).
    exact (is_derive_plus a1 a2 s _ _ D E).
  rewrite <- sum_plus; apply sum_ext; intros; ring.
- intros s Hs; destruct (M1 s Hs) as [X [f [F D]]]; destruct (M2 s Hs) as [Y [g [G E]]].
  split; [now apply sub_reads|].
  exists (fun j => f j + - g j); split.
    apply add_slopes_within; [easy | now apply opposite_within].
  replace (sum n (fun j => (f j + - g j) * e j))
    with (sum n (fun j => f j * e j) - sum n (fun j => g j * e j)).
    exact (is_derive_minus a1 a2 s _ _ D E).
  replace (sum n (fun j => f j * e j) - sum n (fun j => g j * e j))
    with (sum n (fun j => f j * e j) + -1 * sum n (fun j => g j * e j)) by ring.
  rewrite <- sum_scal, <- sum_plus; apply sum_ext; intros; ring.
- intros s Hs; destruct (M1 s Hs) as [X [f [F D]]]; destruct (M2 s Hs) as [Y [g [G E]]].
  split; [now apply mul_reads|].
  exists (fun j => f j * a2 s + g j * a1 s); split.
    now apply add_slopes_within; apply scale_within.
  replace (sum n (fun j => (f j * a2 s + g j * a1 s) * e j))
    with (sum n (fun j => f j * e j) * a2 s + a1 s * sum n (fun j => g j * e j)).
    apply (is_derive_mult a1 a2 s _ _ D E); intros; apply Rmult_comm.
  rewrite (Rmult_comm _ (a2 s)), <- !sum_scal, <- sum_plus; apply sum_ext; intros; ring.
- destruct (is_nonzero (value span y span)) eqn:N; [|easy].
  intros s Hs; destruct (M1 s Hs) as [X [f [F D]]]; destruct (M2 s Hs) as [Y [g [G E]]].
  assert (N' : a2 s <> 0) by (apply nonzero with (1 := N), value_in with time; easy).
  assert (O : reads (TM.inv u span y) (/ a2 s)) by now apply inv_reads.
  assert (Q : reads (TM.mul u span x (TM.inv u span y)) (a1 s / a2 s)) by now apply mul_reads.
  split; [easy|].
  exists (fun j => (f j + g j * - (a1 s / a2 s)) * / a2 s); split.
    apply scale_within; [|easy].
    apply add_slopes_within; [easy | apply scale_within; [easy | now apply opp_reads]].
  replace (sum n (fun j => (f j + g j * - (a1 s / a2 s)) * / a2 s * e j))
    with ((sum n (fun j => f j * e j) * a2 s - a1 s * sum n (fun j => g j * e j)) / a2 s ^ 2).
    apply (is_derive_div a1 a2); easy.
  replace ((sum n (fun j => f j * e j) * a2 s - a1 s * sum n (fun j => g j * e j)) / a2 s ^ 2)
    with (/ a2 s * sum n (fun j => f j * e j)
          + - (a1 s / a2 s) * / a2 s * sum n (fun j => g j * e j)) by now field.
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

End Time.
End Slopes.

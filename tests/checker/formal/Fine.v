(* Taylor models of functions with rounding in their coefficients only. The inverse, sine and cosine
   of CoqInterval also put rounding into the remainder, where it cannot be separated. *)
From Coq Require Import Reals ZArith List Bool Lra Lia.
From Interval Require Import Xreal Interval.Interval Taylor_model_sharp.
From Interval Require Import Eval.Tree Eval.Prog Eval.Eval Tactic.
Require Import Intervals Models.
Import ListNotations.
Open Scope R_scope.

Notation approx := Taylor_model_sharp.approx.
Notation bound_of := Taylor_model_sharp.error.
Notation horner := (Datatypes.PolR.horner tt).
Notation points := TM.Pol.contains_pointwise.

Lemma inv_in x a : x <> 0 -> x \in a -> / x \in I.inv prec a.
Proof.
intros N X; generalize (I.inv_correct prec _ _ X); simpl; unfold Xinv'; now rewrite is_zero_false.
Qed.

(* There is a number in the interval. *)
Definition filled (a : I.type) : Prop := exists x, x \in a.

Lemma inv_filled a : filled a -> filled (I.inv prec a).
Proof.
intros [x X]; generalize (I.inv_correct prec _ _ X); simpl; unfold Xinv'.
destruct (is_zero x); intros H; [exists 0; now destruct (I.convert (I.inv prec a)) | now exists (/ x)].
Qed.

(* One number of an interval, as an interval *)
Definition point (a : I.type) : I.type := A.J.midpoint a.

Lemma point_filled a : filled a -> filled (point a).
Proof. intros F; eexists; exact (A.J.contains_midpoint a F). Qed.

(* 1 / n *)
Definition recip (n : Z) : I.type := I.div prec (integer 1) (integer n).

Lemma recip_in n : n <> 0%Z -> 1 / IZR n \in recip n.
Proof. intros N; apply div_in; [now apply IZR_neq | apply integer_in | apply integer_in]. Qed.

(* Series of sine and cosine in the square, after a factor of the argument in the series of the sine.
   Coefficients are given by their inverses. *)
Fixpoint series (c : list Z) (x : R) : R :=
  match c with nil => 0 | n :: c => 1 / IZR n + x * series c x end.
Definition sines : list Z :=
  [1; -6; 120; -5040; 362880; -39916800; 6227020800; -1307674368000]%Z.
Definition cosines : list Z :=
  [1; -2; 24; -720; 40320; -3628800; 479001600; -87178291200]%Z.
Definition tiny : R := 1 / 10000000000000000000000.

Lemma sine_near w : -1 / 4 <= w <= 1 / 4 -> - tiny <= sin w - w * series sines (w * w) <= tiny.
Proof.
intros H; unfold tiny, sines, series; interval with (i_taylor w, i_prec 120, i_degree 20).
Qed.
Lemma cosine_near w : -1 / 4 <= w <= 1 / 4 -> - tiny <= cos w - series cosines (w * w) <= tiny.
Proof.
intros H; unfold tiny, cosines, series; interval with (i_taylor w, i_prec 120, i_degree 20).
Qed.

Section Fine.
Variable u : TM.U.
Variable span : I.type.

(* The model approximates the function over the span. *)
Definition describes (m : TM.T) (g : R -> R) : Prop :=
  TM.approximates span m (fun s => Xreal (g s)).

(* Operations *)

(* A model of any function with values in the interval *)
Definition ball (e : I.type) : TM.T := TM.Tm (RPA nil (I.join I.zero e)).

Fixpoint dot (a b : list I.type) : I.type :=
  match a, b with x :: a, y :: b => I.add prec (I.mul prec x y) (dot a b) | _, _ => I.zero end.
(* Coefficients of the inverse of a series, the last one first. The inverse of its constant term is r.
   Any numbers would be correct: only the size of the remainder depends on them. *)
Fixpoint guess (n : nat) (r : I.type) (ys qs : list I.type) : list I.type :=
  match n with
  | O => qs
  | S n => guess n r ys (point (I.neg (I.mul prec r (dot ys qs))) :: qs)
  end.

Definition one : TM.T := TM.const (integer 1).

(* With d = 1 - q y, the inverse of y is q (1 + d + d^2 / (1 - d)). *)
Definition inverse (y : TM.T) : TM.T :=
  match y with
  | TM.Const c => if is_nonzero c then TM.const (I.inv prec c) else TM.dummy
  | TM.Tm m =>
    let r := point (I.inv prec (hd I.zero (approx m))) in
    let q := TM.Tm (RPA (rev (guess (snd u) r (tl (approx m)) [r])) I.zero) in
    let d := TM.sub u span one (TM.mul u span q y) in
    let e := value span d span in
    let below := I.sub prec (integer 1) e in
    if is_positive below then
      TM.mul u span q (TM.add u span (TM.add u span one d)
        (ball (I.div prec (I.mul prec e e) below)))
    else TM.dummy
  | TM.Var => TM.dummy
  end.

Fixpoint series_of (c : list Z) (x : TM.T) : TM.T :=
  match c with
  | nil => TM.const I.zero
  | n :: c => TM.add u span (TM.const (recip n)) (TM.mul u span x (series_of c x))
  end.
Definition tiny_ball : TM.T :=
  ball (I.join (I.neg (recip 10000000000000000000000)) (recip 10000000000000000000000)).

(* A number near a model, and how far the model is from it *)
Definition near (m : TM.TMI.rpa) : I.type := point (hd I.zero (approx m)).
Definition away (m : TM.TMI.rpa) : TM.T := TM.sub u span (TM.Tm m) (TM.const (near m)).
(* Sine and cosine of a short model, of at most 1/4 *)
Definition sine_of (w : TM.T) : TM.T :=
  TM.add u span tiny_ball (TM.mul u span w (series_of sines (TM.mul u span w w))).
Definition cosine_of (w : TM.T) : TM.T :=
  TM.add u span tiny_ball (series_of cosines (TM.mul u span w w)).
Definition is_short (w : TM.T) : bool :=
  let e := value span w span in
  is_positive (I.sub prec (recip 4) e) && is_positive (I.add prec (recip 4) e).

Definition sine (y : TM.T) : TM.T :=
  match y with
  | TM.Tm m =>
    let w := away m in
    if is_short w then
      TM.add u span (TM.mul u span (TM.const (I.sin prec (near m))) (cosine_of w))
        (TM.mul u span (TM.const (I.cos prec (near m))) (sine_of w))
    else TM.dummy
  | _ => TM.sin u span y
  end.
Definition cosine (y : TM.T) : TM.T :=
  match y with
  | TM.Tm m =>
    let w := away m in
    if is_short w then
      TM.sub u span (TM.mul u span (TM.const (I.cos prec (near m))) (cosine_of w))
        (TM.mul u span (TM.const (I.sin prec (near m))) (sine_of w))
    else TM.dummy
  | _ => TM.cos u span y
  end.

Definition fine_unary (o : unary_op) (a : TM.T) : TM.T :=
  match o with
  | Neg => TM.opp u span a
  | Sin => sine a
  | Cos => cosine a
  | _ => TM.dummy
  end.
Definition fine_binary (o : binary_op) (a b : TM.T) : TM.T :=
  match o with
  | Add => TM.add u span a b
  | Sub => TM.sub u span a b
  | Mul => TM.mul u span a b
  | Div => TM.mul u span a (inverse b)
  end.
Definition fine_operations : operations TM.T :=
  Build_operations (fun _ => TM.dummy) fine_unary fine_binary (fun _ => Xund).

(* Values of a model without its first five coefficients *)
Definition remainder (m : TM.T) : I.type :=
  match m with
  | TM.Tm r =>
    I.add prec (TM.Pol.horner prec
      (repeat I.zero 5 ++ skipn 5 (approx r)) (I.sub prec span (A.J.midpoint span))) (bound_of r)
  | _ => I.nai
  end.

(* They are correct. *)

Hypothesis bounded : I.convert span <> Inan.
Let center : R := proj_val (I.F.convert (I.midpoint span)).

Lemma describes_ext f g m : (forall s, s \in span -> f s = g s) -> describes m f -> describes m g.
Proof.
intros E D N; specialize (D N); destruct m as [c| |r].
- destruct D as [D|[y Y D]]; [now left | right; exists y; [exact Y|]].
  intros s S; rewrite <- (D s S); now rewrite (E s S).
- intros s S; rewrite <- (D s S); now rewrite (E s S).
- destruct D as [_ D2 D3 D4 [Q HQ D]]; split; [discriminate | exact D2 | exact D3 | exact D4 |].
  exists Q; [exact HQ|]; intros s S; specialize (D s S); simpl in D |- *; now rewrite <- (E s S).
Qed.

Lemma describes_value m g s : s \in span -> describes m g -> g s \in value span m span.
Proof. intros S D; apply value_in with s; [exact S | now exists (fun s => Xreal (g s)) | exact S]. Qed.

Lemma const_describes c v : v \in c -> describes (TM.const c) (fun _ => v).
Proof. intros V; exact (TM.const_correct V (X := span)). Qed.
Lemma add_describes a b f g :
  describes a f -> describes b g -> describes (TM.add u span a b) (fun s => f s + g s).
Proof. intros D E; exact (TM.add_correct u D E). Qed.
Lemma sub_describes a b f g :
  describes a f -> describes b g -> describes (TM.sub u span a b) (fun s => f s - g s).
Proof. intros D E; exact (TM.sub_correct u D E). Qed.
Lemma mul_describes a b f g :
  describes a f -> describes b g -> describes (TM.mul u span a b) (fun s => f s * g s).
Proof. intros D E; exact (TM.mul_correct u D E). Qed.
Lemma opp_describes a f : describes a f -> describes (TM.opp u span a) (fun s => - f s).
Proof. intros D; exact (TM.opp_correct u D). Qed.
Lemma dummy_describes g : describes TM.dummy g.
Proof. apply TM.dummy_correct. Qed.

Lemma made l e q g :
  points l q -> 0 \in e -> (forall s, s \in span -> g s - horner q (s - center) \in e) ->
  describes (TM.Tm (RPA l e)) g.
Proof.
intros L E G N; split; [discriminate | now intros H; elim bounded | exact E | |].
- destruct (I.midpoint_correct span N) as [M C]; fold center; unfold center, I.F.convert.
  unfold I.F.toX in *; now rewrite <- M.
- exists q; [exact L | exact G].
Qed.

Lemma ball_describes e g : (forall s, s \in span -> g s \in e) -> describes (ball e) g.
Proof.
intros G; apply made with (q := nil).
- intros k; destruct k; apply zero_in.
- apply I.join_correct; left; apply zero_in.
- intros s S; replace (g s - horner nil (s - center)) with (g s) by (simpl; ring).
  apply I.join_correct; right; auto.
Qed.

Lemma filled_points l : Forall filled l -> exists q, points l q.
Proof.
induction 1 as [|a l [x X] _ [q Q]].
  exists nil; intros k; destruct k; apply zero_in.
exists (x :: q); intros k; destruct k as [|k]; [exact X | exact (Q k)].
Qed.

Lemma points_filled l q : points l q -> Forall filled l.
Proof.
revert q; induction l as [|a l IH]; intros q Q; constructor.
  exists (Datatypes.PolR.nth q 0); exact (Q O).
apply (IH (tl q)); intros k; specialize (Q (S k)).
destruct q; [|exact Q]; destruct k; exact Q.
Qed.

Lemma dot_filled a : forall b, Forall filled a -> Forall filled b -> filled (dot a b).
Proof.
induction a as [|x a IH]; intros b A B; [exists 0; apply zero_in|].
destruct B as [|y b Y B]; [exists 0; apply zero_in|].
inversion A as [|? ? [v V] A']; destruct Y as [w W], (IH b A' B) as [z Z].
exists (v * w + z); apply add_in; [now apply mul_in | exact Z].
Qed.

Lemma guess_filled n r ys : filled r -> Forall filled ys -> forall qs,
  Forall filled qs -> Forall filled (guess n r ys qs).
Proof.
intros [v V] Y; induction n as [|n IH]; intros qs Q; [exact Q|]; cbn [guess].
apply IH; constructor; [|exact Q]; apply point_filled.
destruct (dot_filled ys qs Y Q) as [w W]; exists (- (v * w)); now apply neg_in, mul_in.
Qed.

Lemma head_filled l : Forall filled l -> filled (hd I.zero l).
Proof. intros [|a l' F _]; [exists 0; apply zero_in | exact F]. Qed.

Lemma coefficients_filled r g :
  not_empty (I.convert span) -> describes (TM.Tm r) g -> Forall filled (approx r).
Proof. intros N D; destruct (D N) as [_ _ _ _ [q Q _]]; exact (points_filled _ q Q). Qed.

Lemma constant_is c g : describes (TM.Const c) g -> not_empty (I.convert span) ->
  I.convert c = Inan \/ exists v, v \in c /\ forall s, s \in span -> g s = v.
Proof.
intros D N; destruct (D N) as [H|[y Y H]]; [now left | right].
destruct N as [s S]; exists (g s); split; [now rewrite (H s S)|].
intros t T; specialize (H s S) as E; rewrite <- (H t T) in E; now injection E.
Qed.

Lemma inverse_describes y g : describes y g -> describes (inverse y) (fun s => / g s).
Proof.
intros D N; destruct y as [c| |m]; cbn [inverse]; [|now apply dummy_describes|].
- destruct (is_nonzero c) eqn:Z; [|now apply dummy_describes].
  destruct (constant_is c g D N) as [H|[v [V E]]].
    assert (O : 0 \in c) by now rewrite H.
    now elim (nonzero _ _ Z O).
  apply describes_ext with (fun _ => / v); [|apply const_describes, inv_in|exact N].
    intros s S; now rewrite (E s S).
    now apply nonzero with c.
    exact V.
- set (r := point _); set (l := rev _); set (d := TM.sub _ _ _ _); set (e := value _ _ _).
  destruct (is_positive _) eqn:P; [|now apply dummy_describes].
  assert (F := coefficients_filled m g N D).
  assert (R : filled r) by now apply point_filled, inv_filled, head_filled.
  destruct (filled_points l) as [q Q].
    apply Forall_rev, guess_filled; [exact R | | now constructor].
    destruct F; [constructor | assumption].
  set (f := fun s => horner q (s - center)).
  assert (Df : describes (TM.Tm (RPA l I.zero)) f).
    apply made with q; [exact Q | apply zero_in |].
    intros s S; unfold f; rewrite Rminus_diag_eq by easy; apply zero_in.
  assert (Dd : describes d (fun s => 1 - f s * g s)).
    apply sub_describes; [apply const_describes, (integer_in 1) | now apply mul_describes].
  assert (Below : forall s, s \in span -> 1 - (1 - f s * g s) \in I.sub prec (integer 1) e).
    intros s S; apply sub_in; [apply (integer_in 1)|].
    exact (describes_value d (fun s => 1 - f s * g s) s S Dd).
  assert (Pos : forall s, s \in span -> 0 < f s * g s).
    intros s S; generalize (positive _ _ P (Below s S)); lra.
  apply describes_ext with (fun s => f s * (1 + (1 - f s * g s)
    + (1 - f s * g s) * (1 - f s * g s) / (1 - (1 - f s * g s)))); [| |exact N].
    intros s S; specialize (Pos s S); field.
    split; [intros E | intros E]; [|replace (1 - (1 - f s * g s)) with (f s * g s) in E by ring; lra].
    rewrite E in Pos; lra.
  apply mul_describes; [exact Df|]; apply add_describes.
    apply add_describes; [apply const_describes, (integer_in 1) | exact Dd].
  apply ball_describes; intros s S; apply div_in; [specialize (Pos s S); lra | | now apply Below].
  assert (V := describes_value d (fun s => 1 - f s * g s) s S Dd); now apply mul_in.
Qed.

Lemma series_describes c x f : Forall (fun n => n <> 0%Z) c -> describes x f ->
  describes (series_of c x) (fun s => series c (f s)).
Proof.
induction 1 as [|n c H _ IH]; intros D; cbn [series_of series]; [apply const_describes, zero_in|].
apply add_describes; [now apply const_describes, recip_in | apply mul_describes; auto].
Qed.

Lemma tiny_describes g : (forall s, s \in span -> - tiny <= g s <= tiny) -> describes tiny_ball g.
Proof.
intros G; apply ball_describes; intros s S.
apply between_in with (- tiny) tiny; [| | exact (G s S)]; apply I.join_correct; [left | right].
- apply neg_in, (recip_in 10000000000000000000000); easy.
- apply (recip_in 10000000000000000000000); easy.
Qed.

Lemma short w f : is_short w = true -> describes w f ->
  forall s, s \in span -> -1 / 4 <= f s <= 1 / 4.
Proof.
unfold is_short; rewrite andb_true_iff; intros [U L] D s S.
assert (V := describes_value w f s S D); assert (R := recip_in 4 ltac:(easy)).
pose proof (positive _ _ U (sub_in _ _ _ _ R V)).
pose proof (positive _ _ L (add_in _ _ _ _ R V)); lra.
Qed.

Lemma sine_of_describes w f : describes w f -> (forall s, s \in span -> -1 / 4 <= f s <= 1 / 4) ->
  describes (sine_of w) (fun s => sin (f s)).
Proof.
intros D H.
apply describes_ext with (fun s => (sin (f s) - f s * series sines (f s * f s))
  + f s * series sines (f s * f s)); [intros; ring|].
apply add_describes; [apply tiny_describes; intros s S; now apply sine_near, H|].
apply mul_describes; [exact D|]; apply series_describes with (f := fun s => f s * f s).
  repeat constructor; easy.
now apply mul_describes.
Qed.

Lemma cosine_of_describes w f : describes w f -> (forall s, s \in span -> -1 / 4 <= f s <= 1 / 4) ->
  describes (cosine_of w) (fun s => cos (f s)).
Proof.
intros D H.
apply describes_ext with (fun s => (cos (f s) - series cosines (f s * f s))
  + series cosines (f s * f s)); [intros; ring|].
apply add_describes; [apply tiny_describes; intros s S; now apply cosine_near, H|].
apply series_describes with (f := fun s => f s * f s); [repeat constructor; easy | now apply mul_describes].
Qed.

Lemma away_describes m g : not_empty (I.convert span) -> describes (TM.Tm m) g ->
  exists v, v \in near m /\ describes (away m) (fun s => g s - v).
Proof.
intros N D; destruct (point_filled _ (head_filled _ (coefficients_filled m g N D))) as [v V].
exists v; split; [exact V|]; apply sub_describes; [exact D | now apply const_describes].
Qed.

Lemma sin_in x a : x \in a -> sin x \in I.sin prec a.
Proof. intros X; exact (I.sin_correct prec _ _ X). Qed.
Lemma cos_in x a : x \in a -> cos x \in I.cos prec a.
Proof. intros X; exact (I.cos_correct prec _ _ X). Qed.

Lemma sine_describes y g : describes y g -> describes (sine y) (fun s => sin (g s)).
Proof.
intros D; destruct y as [c| |m]; [apply (@TM.sin_correct u span _ (fun s => Xreal (g s))), D | | ];
  [apply (@TM.sin_correct u span _ (fun s => Xreal (g s))), D |].
cbn [sine]; destruct (is_short _) eqn:H; [|apply dummy_describes].
intros N; destruct (away_describes m g N D) as [v [V W]].
apply describes_ext with (fun s => sin v * cos (g s - v) + cos v * sin (g s - v)); [| |exact N].
  intros s _; rewrite <- sin_plus; f_equal; ring.
pose proof (short _ _ H W) as S; apply add_describes; apply mul_describes.
- now apply const_describes, sin_in.
- now apply cosine_of_describes with (f := fun s => g s - v).
- now apply const_describes, cos_in.
- now apply sine_of_describes with (f := fun s => g s - v).
Qed.

Lemma cosine_describes y g : describes y g -> describes (cosine y) (fun s => cos (g s)).
Proof.
intros D; destruct y as [c| |m]; [apply (@TM.cos_correct u span _ (fun s => Xreal (g s))), D | | ];
  [apply (@TM.cos_correct u span _ (fun s => Xreal (g s))), D |].
cbn [cosine]; destruct (is_short _) eqn:H; [|apply dummy_describes].
intros N; destruct (away_describes m g N D) as [v [V W]].
apply describes_ext with (fun s => cos v * cos (g s - v) - sin v * sin (g s - v)); [| |exact N].
  intros s _; rewrite <- cos_plus; f_equal; ring.
pose proof (short _ _ H W) as S; apply sub_describes; apply mul_describes.
- now apply const_describes, cos_in.
- now apply cosine_of_describes with (f := fun s => g s - v).
- now apply const_describes, sin_in.
- now apply sine_of_describes with (f := fun s => g s - v).
Qed.

Lemma fine_program program (inputs : R -> list R) (models : list TM.T) i :
  (forall j, describes (nth j models TM.dummy) (fun s => nth j (inputs s) 0)) ->
  describes (nth i (eval_generic TM.dummy fine_operations program models) TM.dummy)
    (fun s => nth i (eval_real program (inputs s)) 0).
Proof.
intros H; unfold eval_real.
apply (eval_inductive_prop_fun R TM.T (fun f m => describes m f)).
- intros a b E m; apply describes_ext; intros s _; apply E.
- apply dummy_describes.
- intros o a m D; destruct o; try apply dummy_describes;
    cbn [unary fine_operations fine_unary real_operations unary_real].
  + now apply opp_describes.
  + now apply cosine_describes.
  + now apply sine_describes.
- intros o a1 a2 m1 m2 D1 D2; destruct o;
    cbn [binary fine_operations fine_binary real_operations binary_real].
  + now apply add_describes.
  + now apply sub_describes.
  + now apply mul_describes.
  + now apply mul_describes; [|apply inverse_describes].
- exact H.
Qed.

(* Five times of a span of 1/16 s *)
Definition node (j : Z) : R := IZR j / 64.
Definition nodes : list Z := [-2; -1; 0; 1; 2]%Z.

Lemma horner_tail q x : horner q x = Datatypes.PolR.nth q 0 + x * horner (tl q) x.
Proof. destruct q; simpl; ring. Qed.

Lemma nth_tail q k : Datatypes.PolR.nth (tl q) k = Datatypes.PolR.nth q (S k).
Proof. destruct q, k; reflexivity. Qed.

Lemma nth_skip l j : TM.Pol.nth (skipn 5 l) j = TM.Pol.nth l (S (S (S (S (S j))))).
Proof. do 5 (destruct l as [|? l]; [now destruct j|]); reflexivity. Qed.

Lemma remainder_correct m f : not_empty (I.convert span) -> describes m f ->
  exists a b c d e, forall s, s \in span -> let x := s - center in
  f s - (a + x * (b + x * (c + x * (d + x * e)))) \in remainder m.
Proof.
intros N D; destruct m as [c| |r]; try (exists 0, 0, 0, 0, 0; easy).
destruct (D N) as [_ _ _ _ [q Q E]].
set (k := Datatypes.PolR.nth q); exists (k 0%nat), (k 1%nat), (k 2%nat), (k 3%nat), (k 4%nat).
set (z := repeat 0 5 ++ tl (tl (tl (tl (tl q))))).
intros s Hs x; replace (f s - _) with (horner z x + (f s - horner q x)).
- apply add_in; [|exact (E s Hs)]; apply TM.Pol.horner_correct.
    intros j; do 5 (destruct j as [|j]; [apply zero_in|]).
    specialize (Q (S (S (S (S (S j)))))); unfold z.
    change (Datatypes.PolR.nth (repeat 0 5 ++ ?l) (S (S (S (S (S j)))))) with (Datatypes.PolR.nth l j).
    rewrite !nth_tail.
    change (TM.Pol.nth (repeat I.zero 5 ++ ?l) (S (S (S (S (S j)))))) with (TM.Pol.nth l j).
    now rewrite nth_skip.
  apply sub_in; [exact Hs | apply A.J.contains_midpoint, N].
- rewrite (horner_tail q), (horner_tail (tl q)), (horner_tail (tl (tl q))), (horner_tail (tl (tl (tl q)))),
    (horner_tail (tl (tl (tl (tl q))))), !nth_tail; unfold z, k; simpl; ring.
Qed.

(* The weights of the values in the interpolation between the five times *)
Definition weights (x : R) : list R :=
  [(x + 1) * x * (x - 1) * (x - 2) / 24; - ((x + 2) * x * (x - 1) * (x - 2)) / 6;
   (x + 2) * (x + 1) * (x - 1) * (x - 2) / 4; - ((x + 2) * (x + 1) * x * (x - 2)) / 6;
   (x + 2) * (x + 1) * x * (x - 1) / 24].

Lemma weights_limited x : -2 <= x <= 2 -> Forall (fun w => - (6 / 5) <= w <= 6 / 5) (weights x).
Proof. intros H; repeat constructor; interval with (i_bisect x, i_depth 20). Qed.

Definition weight : I.type :=
  let w := I.div prec (integer 6) (integer 5) in I.join (I.neg w) w.
(* Values of a function between five times, from its values there and the remainder of its model *)
Definition between (rest : I.type) (values : list I.type) : I.type :=
  fold_right (fun v sum => I.add prec sum (I.mul prec weight (I.sub prec v rest))) rest values.

Lemma weight_in w : - (6 / 5) <= w <= 6 / 5 -> w \in weight.
Proof.
assert (E : 6 / 5 \in I.div prec (integer 6) (integer 5)).
  apply div_in; [lra | apply (integer_in 6) | apply (integer_in 5)].
apply between_in; apply I.join_correct; [left; now apply neg_in | now right].
Qed.

(* r plus the weighted sum of the values *)
Fixpoint mixed (ws values : list R) (r : R) : R :=
  match ws, values with w :: ws, v :: values => mixed ws values r + w * v | _, _ => r end.

Lemma mixed_in rest r ws : Forall (fun w => - (6 / 5) <= w <= 6 / 5) ws -> r \in rest ->
  forall xs values, length ws = length xs -> Forall2 (fun x v => x \in I.sub prec v rest) xs values ->
  mixed ws xs r \in between rest values.
Proof.
intros W Hr; induction W as [|w ws Hw _ IH]; intros xs values L F.
  destruct F; [exact Hr | discriminate L].
destruct F as [|x v xs values X F]; [discriminate L|].
apply add_in; [now apply IH; [injection L|] | apply mul_in; [now apply weight_in | exact X]].
Qed.

Lemma between_correct m f values :
  (forall s, -1 / 32 <= s <= 1 / 32 -> s \in span) ->
  describes m f -> Forall2 (fun j v => f (node j) \in v) nodes values ->
  forall s, -1 / 32 <= s <= 1 / 32 -> f s \in between (remainder m) values.
Proof.
intros Covers D V s Hs.
destruct (remainder_correct m f) as [a [b [c [d [e E]]]]]; [now exists s; apply Covers | exact D |].
set (low := fun s => let x := s - center in a + x * (b + x * (c + x * (d + x * e)))).
assert (Rest : forall s, -1 / 32 <= s <= 1 / 32 -> f s - low s \in remainder m).
  intros r Hr; exact (E r (Covers r Hr)).
replace (f s) with (mixed (weights (64 * s)) (map (fun j => low (node j)) nodes) (f s - low s)).
- apply mixed_in; [apply weights_limited; lra | exact (Rest s Hs) | reflexivity |].
  assert (N : Forall (fun j => -1 / 32 <= node j <= 1 / 32) nodes).
    unfold node; repeat constructor; lra.
  clear - V N Rest; induction V as [|j v js vs Hv _ IH]; [constructor|].
  inversion_clear N as [|? ? Hj N']; constructor; [|exact (IH N')].
  replace (low (node j)) with (f (node j) - (f (node j) - low (node j))) by ring.
  apply sub_in; [exact Hv | exact (Rest _ Hj)].
- unfold weights, nodes, node, low; cbn [mixed map]; field.
Qed.

End Fine.

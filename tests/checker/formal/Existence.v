(* Theorem 1 for polynomials in one bicycle: there is exactly one motion.

   On a piece the equations are changed: outside the tube they have the rates of the nearest state
   in it. Their solution does not reach the tube's wall, so it obeys the equations themselves. *)
From Coq Require Import Reals QArith Qreals ZArith List Bool Lra Lia.
From Coquelicot Require Import Coquelicot.
From Interval Require Import Xreal Interval.Interval Float_full Tactic_float.
From Interval Require Import Eval.Tree Eval.Prog Eval.Eval.
Require Import Picard Growth Sums Intervals Models Slopes Squares Defects.
Require Export Enclosure.
Import ListNotations.
Open Scope R_scope.

(* Along a continuous path in the boxes the value of a program is continuous if its slopes are found. *)
Section Continuity.
Variable u : TM.U.
Variable span : I.type.
Variable time : R -> R.
Hypothesis inside : forall t, time t \in span.

Definition follows (a : R -> R) (b : sloped) : Prop :=
  match b with
  | None => True
  | Some (x, _) => forall t, reads span (time t) x (a t) /\ continuous a t
  end.

Lemma follows_ext a b m : (forall t, a t = b t) -> follows a m -> follows b m.
Proof.
intros E; destruct m as [[x p]|]; [|easy]; intros F t; destruct (F t) as [X C].
rewrite <- E; split; [easy | now apply (continuous_ext a)].
Qed.

Lemma follows_unary o a b :
  follows a b -> follows (fun t => unary real_operations o (a t)) (sloped_unary u span o b).
Proof.
destruct b as [[x p]|]; [|now destruct o].
destruct o; try easy; intros F t; destruct (F t) as [X C]; split.
- now apply opp_reads.
- now apply (continuous_opp a).
- now apply cos_reads.
- now apply continuous_cos_comp.
- now apply sin_reads.
- now apply continuous_sin_comp.
Qed.

Lemma follows_binary o a1 a2 b1 b2 :
  follows a1 b1 -> follows a2 b2 ->
  follows (fun t => binary real_operations o (a1 t) (a2 t)) (sloped_binary u span o b1 b2).
Proof.
destruct b1 as [[x p]|]; [|easy].
destruct b2 as [[y q]|]; [|easy].
intros F1 F2; destruct o; cbn [follows sloped_binary binary real_operations binary_real].
- intros t; destruct (F1 t) as [X C]; destruct (F2 t) as [Y D]; split; [now apply add_reads|].
  now apply (continuous_plus a1 a2).
- intros t; destruct (F1 t) as [X C]; destruct (F2 t) as [Y D]; split; [now apply sub_reads|].
  now apply (continuous_minus a1 a2).
- intros t; destruct (F1 t) as [X C]; destruct (F2 t) as [Y D]; split; [now apply mul_reads|].
  now apply (continuous_mult a1 a2).
- destruct (is_nonzero (value span y span)) eqn:N; [|easy].
  intros t; destruct (F1 t) as [X C]; destruct (F2 t) as [Y D].
  assert (N' : a2 t <> 0) by (apply nonzero with (1 := N), value_in with (time t); easy).
  split; [apply mul_reads; [easy | now apply inv_reads]|].
  apply (continuous_mult a1 (fun t => / a2 t)); [easy | now apply continuous_Rinv_comp].
Qed.

Lemma follows_program program (inputs : R -> list R) (boxes : list sloped) i :
  (forall j, follows (fun t => nth j (inputs t) 0) (nth j boxes None)) ->
  follows (fun t => nth i (eval_real program (inputs t)) 0)
          (nth i (eval_generic None (sloped_operations u span) program boxes) None).
Proof.
intros H; unfold eval_real.
apply (eval_inductive_prop_fun R sloped (fun a b => follows a b)); try easy.
- intros a b E m; now apply follows_ext.
- apply follows_unary.
- apply follows_binary.
Qed.
End Continuity.

Section Bicycle.
Variable program : list term.
Variable integers : list Z.
Variable start : list (Z * Z).
Local Notation constants := (constants integers).
Local Notation field := (field program integers).
Local Notation motion := (motion program integers).
Local Notation begins := (begins start).
Local Notation missing_squares := (missing_squares program integers).
Local Notation slopes_found := (slopes_found program integers).
Local Notation boxes_of := (boxes_of integers).
Local Notation check_piece := (check_piece program integers).
Local Notation check_chain := (check_chain program integers).
Local Notation check_start := (check_start start).
Local Notation check_block := (check_block program integers).
Local Notation guided := (guided program integers).
Local Notation all_checked := (all_checked program integers).

Definition all_slopes (p : piece) : bool :=
  all_states (fun i => has_slopes (nth i (slopes_found p) None)).

(* A change of the state changes each rate by at most this factor times the largest change of a
   variable. *)
Definition steepness : R := INR count * IZR steepest.

Lemma steepest_positive : 0 < IZR steepest.
Proof. now apply IZR_lt. Qed.

Lemma slope_limited p s i j g :
  all_slopes p = true -> - half <= s <= half -> (i < count)%nat -> (j < count)%nat ->
  (forall a, s \in a -> g \in slope_at (nth i (slopes_found p) None) j a) ->
  Rabs g <= IZR steepest.
Proof.
intros A Hs Hi Hj G; assert (H := all_states_spec _ i A Hi); cbv beta in H; unfold has_slopes in H.
destruct (nth i (slopes_found p) None) as [m|]; [|discriminate H].
apply (all_states_spec _ j) in H; [|exact Hj]; unfold is_gentle in H; rewrite andb_true_iff in H.
destruct H as [Up Down]; specialize (G span (span_in s Hs)).
pose proof (positive _ _ Up (sub_in _ _ _ _ (integer_in steepest) G)).
pose proof (positive _ _ Down (add_in _ _ _ _ (integer_in steepest) G)).
apply Rabs_le_between; lra.
Qed.

(* The rates in the nearest state for which every variable differs from its polynomial by at most
   the error of the tube *)
Section Held.
Variable p : piece.
Variable t : R. (* the middle of the piece *)
Hypothesis sloped_piece : all_slopes p = true.

Definition local (s : R) : R := clamp (- half) half (s - t).
Definition held_gap (s : R) (y : nat -> R) (j : nat) : R :=
  clamp (- error) error (y j - candidate p j (local s)).
Definition held (s : R) (y : nat -> R) (i : nat) : R :=
  field i (map (fun j => candidate p j (local s) + held_gap s y j) (seq 0 count)).

Lemma local_between s : - half <= local s <= half.
Proof. apply clamp_between; unfold half; lra. Qed.

Lemma held_gap_small s y j : Rabs (held_gap s y j) <= error.
Proof. apply Rabs_le_between, clamp_between; unfold error; lra. Qed.

Lemma held_Lipschitz s y z d :
  (forall j, (j < count)%nat -> Rabs (y j - z j) <= d) ->
  forall i, (i < count)%nat -> Rabs (held s y i - held s z i) <= steepness * d.
Proof.
intros H i Hi.
destruct (field_change program integers p (local s) (held_gap s z) (held_gap s y) i) as [g [G E]];
  [apply local_between | intros j _; apply held_gap_small | intros j _; apply held_gap_small
  | exact (all_states_spec _ i sloped_piece Hi) |].
unfold held; rewrite E; clear E.
assert (Each : forall j, (j < count)%nat ->
  Rabs (g j * (held_gap s y j - held_gap s z j)) <= IZR steepest * d).
  intros j Hj; rewrite Rabs_mult; apply Rmult_le_compat; try apply Rabs_pos.
    apply (slope_limited p (local s) i j); try easy; [apply local_between | intros a; apply G].
  apply Rle_trans with (2 := H j Hj), Rle_trans with (1 := clamp_near _ _ _ _).
  right; f_equal; ring.
unfold steepness; clear - Each; induction count as [|n IH]; [simpl; rewrite Rabs_R0; lra|].
cbn [sum]; rewrite S_INR; apply Rle_trans with (1 := Rabs_triang _ _).
specialize (IH (fun j Hj => Each j ltac:(lia))); specialize (Each n ltac:(lia)); lra.
Qed.

Lemma continuous_local s : continuous local s.
Proof.
apply (continuous_comp (fun s => s - t) (clamp (- half) half)); [|apply continuous_clamp].
apply (continuous_minus (fun s => s) (fun _ => t)); [apply continuous_id | apply continuous_const].
Qed.

Lemma continuous_held (y : nat -> R -> R) :
  (forall j, (j < count)%nat -> forall s, continuous (y j) s) ->
  forall i, (i < count)%nat -> forall s, continuous (fun s => held s (fun j => y j s) i) s.
Proof.
intros Y i Hi s.
set (path := fun j s => candidate p j (local s) + held_gap s (fun j => y j s) j).
assert (F : follows span local
  (fun s => nth i (eval_real program (map (fun j => path j s) (seq 0 count) ++ constants)) 0)
  (nth i (slopes_found p) None)).
  apply (follows_program coarse span local (fun s => span_in _ (local_between s)) program
    (fun s => map (fun j => path j s) (seq 0 count) ++ constants)).
  apply (inputs_have integers (follows span local)); [apply follows_ext | easy | |].
    intros v a V r; split; [now apply const_reads | apply continuous_const].
  intros j Hj r; split.
    apply in_box; [apply span_in, local_between | apply held_gap_small].
  assert (C : continuous (fun s => candidate p j (local s)) r).
    apply (continuous_comp local (candidate p j)); [apply continuous_local|].
    apply (ex_derive_continuous (candidate p j)).
    exists (slope_of (nth j (coefficients p) nil) (local r)); apply is_derive_polynomial.
  apply (continuous_plus (fun s => candidate p j (local s))); [exact C|].
  apply (continuous_comp (fun s => y j s - candidate p j (local s)) (clamp (- error) error));
    [|apply continuous_clamp].
  now apply (continuous_minus (y j)); [apply Y|].
assert (H := all_states_spec _ i sloped_piece Hi); cbv beta in H.
destruct (nth i (slopes_found p) None) as [[x l]|]; [|discriminate H].
exact (proj2 (F s)).
Qed.

(* In the tube the held rates are those of the equations. *)
Lemma held_inside s (y : nat -> R -> R) i :
  - half <= s - t <= half ->
  (forall j, (j < count)%nat -> Rabs (y j s - candidate p j (s - t)) <= error) ->
  held s (fun j => y j s) i = field i (state y s).
Proof.
intros Hs H; unfold held; f_equal; apply map_ext_in; intros j Hj; apply in_seq in Hj.
specialize (H j ltac:(lia)); apply Rabs_le_between in H.
unfold held_gap, local; rewrite (clamp_inside _ _ (s - t)), clamp_inside by easy; ring.
Qed.
End Held.

Section Frame.
Variable c : certificate.
Hypothesis framed : check_frame c = true.
Local Notation chain := (check_chain (matrix_in (frame c)) (matrix_in (inverse c)) (rational (tube c))).

Lemma piece_slopes out back p : check_piece out back p = true -> all_slopes p = true.
Proof. unfold check_piece; rewrite !andb_true_iff; now intros [[[H _] _] _]. Qed.

Lemma state_same x y s : (forall i, x i s = y i s) -> state x s = state y s.
Proof. intros E; apply map_ext, E. Qed.

Lemma squares_same p x y t s :
  (forall i, x i (t + s) = y i (t + s)) -> squares c p x t s = squares c p y t s.
Proof.
intros E; apply sum_ext; intros i _; unfold coordinate, gap.
f_equal; apply sum_ext; intros j _; now rewrite E.
Qed.

(* A motion up to the beginning of a piece continues to its end. *)
Lemma piece_exists p rest next W w x t :
  chain next W (p :: rest) = true -> motion x (t - half) -> half <= t -> 0 <= w -> w \in W ->
  squares c p x t (- half) <= w ->
  exists y, motion y (t + half) /\ forall i s, s <= t - half -> y i s = x i s.
Proof.
intros C M Ht W0 HW Entry; pose proof half_positive as H0.
assert (Slopes := piece_slopes _ _ _ (first_checked program integers _ _ _ _ _ _ _ C)).
destruct (picard count (held p t) (fun i => x i (t - half)) (t - half) (t + half) steepness)
  as [z [Z0 Z]]; [| lra | now apply held_Lipschitz | now apply continuous_held |].
  apply Rmult_lt_0_compat; [apply lt_0_INR; unfold count; lia | apply steepest_positive].
assert (Same : forall v, - half <= v <= half -> squares c p z t v < Q2R (tube c) ->
  forall i, held p t (t + v) (fun j => z j (t + v)) i = field i (state z (t + v))).
  intros v Hv Below i; apply held_inside; replace (t + v - t) with v by ring; [exact Hv|].
  intros j Hj; apply (gap_small c framed p z t v j Hj); lra.
assert (G : guided c p z (t + half) t).
  intros v Hv _ i Hi; assert (D := Z (t + v) ltac:(lra) i Hi); split; [now eexists; exact D|].
  intros Below; now rewrite <- Same.
destruct (first_correct program integers c framed p rest next W w z (t + half) t C G W0 HW)
  as [b [_ [L [_ In]]]].
  intros _; apply Rle_trans with (2 := Entry); right; apply squares_same; intros i; now rewrite Z0.
assert (Moves : forall s, t - half <= s <= t + half -> forall i, (i < count)%nat ->
  is_derive (z i) s (field i (state z s))).
  intros s Hs i Hi; replace s with (t + (s - t)) by ring.
  apply G; [lra | lra | exact Hi | apply Rle_lt_trans with (2 := L), In; lra].
exists (fun i => glued (x i) (z i) (t - half)); split; [|intros i s Hs; now apply glued_before].
intros s Hs i Hi; destruct (Rtotal_order s (t - half)) as [B|[E|B]].
- rewrite (state_same _ x) by (intros j; apply glued_before; lra).
  apply is_derive_before; [exact B | apply M; [lra | exact Hi]].
- rewrite (state_same _ x) by (intros j; apply glued_before; lra).
  subst s; apply is_derive_glued; [now rewrite Z0 | apply M; [lra | exact Hi] |].
  rewrite (state_same x z) by (intros j; now rewrite Z0); apply Moves; [lra | exact Hi].
- rewrite (state_same _ z) by (intros j; apply glued_after; [now rewrite Z0 | lra]).
  apply is_derive_after; [exact B | apply Moves; [lra | exact Hi]].
Qed.

Lemma chain_exists pieces : forall x t w W next,
  chain next W pieces = true -> motion x (t - half) -> half <= t -> 0 <= w -> w \in W ->
  match pieces with nil => True | p :: _ => squares c p x t (- half) <= w end ->
  exists y, motion y (t + 2 * INR (length pieces) * half - half) /\
  forall i s, s <= t - half -> y i s = x i s.
Proof.
pose proof half_positive as H0.
induction pieces as [|p rest IH]; intros x t w W next C M Ht W0 HW Entry.
  exists x; split; [|easy].
  now replace (t + 2 * INR (length (@nil piece)) * half - half) with (t - half) by (simpl; ring).
assert (Piece := first_checked program integers _ _ _ _ _ _ _ C).
destruct (piece_exists p rest next W w x t C M Ht W0 HW Entry) as [y [My Sy]].
assert (Gy := motion_guided program integers c p y (t + half) t My Ht).
destruct (first_correct program integers c framed p rest next W w y (t + half) t C Gy W0 HW)
  as [b [B0 [_ [B Inside]]]].
  intros _; apply Rle_trans with (2 := Entry); right; apply squares_same; intros i; apply Sy; lra.
cbn [Checks.check_chain] in C; rewrite !andb_true_iff in C; destruct C as [_ C].
destruct rest as [|q rest].
  exists y; split; [|exact Sy].
  now replace (t + 2 * INR (length [p]) * half - half) with (t + half) by (simpl; ring).
destruct (IH y (t + 2 * half) (real_after b (turned_squares c (jump p q)))
  (after_jump (bound (scaled (rate p) 10) W (above (missing_squares (matrix_in (inverse c)) p)))
     (squares_in (matrix_in (inverse c)) (jump_in p q))) next) as [z [Mz Sz]];
  [exact C | | lra | apply after_nonneg; [exact B0 | apply turned_nonneg] | | |].
- now replace (t + 2 * half - half) with (t + half) by ring.
- apply after_in; [exact B0 | apply turned_nonneg | exact B |].
  apply turned_in; intros j Hj; apply jump_is_in; [exact (piece_terms program integers c p j Piece Hj)|].
  exact (piece_terms program integers c q j (first_checked program integers _ _ _ _ _ _ _ C) Hj).
- apply jump_correct; [exact B0 | apply Inside; lra].
- exists z; split.
    change (length (p :: q :: rest)) with (S (length (q :: rest))); rewrite S_INR.
    now replace (t + 2 * (INR (length (q :: rest)) + 1) * half - half)
      with (t + 2 * half + 2 * INR (length (q :: rest)) * half - half) by ring.
  intros i s Hs; rewrite Sz by lra; now apply Sy.
Qed.

Lemma blocks_exist blocks : forall x t,
  all_checked c blocks -> motion x (t - half) -> half <= t ->
  match blocks with
  | nil => True
  | b :: _ => forall p, nth_error (members b) 0 = Some p ->
      squares c p x t (- half) <= Q2R (entry_of b)
  end ->
  exists y, motion y (t + 2 * INR (length (concat (map members blocks))) * half - half) /\
  forall i s, s <= t - half -> y i s = x i s.
Proof.
pose proof half_positive as H0.
induction blocks as [|b rest IH]; intros x t A M Ht Entry.
  exists x; split; [|easy].
  now replace (t + 2 * INR (length (concat (map members nil))) * half - half) with (t - half)
    by (simpl; ring).
destruct A as [C [Some_ [E0 A]]]; unfold check_block in C.
assert (First : match members b with
  | nil => True | p :: _ => squares c p x t (- half) <= Q2R (entry_of b) end).
  destruct (members b) as [|q l]; [exact Logic.I | exact (Entry q eq_refl)].
destruct (chain_exists (members b) x t (Q2R (entry_of b)) (rational (entry_of b)) _ C M Ht E0
  (rational_in (entry_of b)) First) as [y [My Sy]].
set (T := t + 2 * INR (length (members b)) * half) in *.
assert (HT : half <= T).
  pose proof (pos_INR (length (members b))) as N.
  assert (0 <= INR (length (members b)) * half) by (apply Rmult_le_pos; lra); unfold T; lra.
destruct (chain_correct program integers c framed (members b) y (T - half) t (Q2R (entry_of b))
  (rational (entry_of b)) _ C My Ht E0 (rational_in (entry_of b))) as [_ End].
  destruct (members b) as [|q l]; [exact Logic.I|]; intros _.
  apply Rle_trans with (2 := First); right; apply squares_same; intros i; apply Sy; lra.
destruct (IH y T A My HT) as [z [Mz Sz]].
  destruct rest as [|n rest]; [exact Logic.I|]; intros q Q.
  unfold first_of in End; destruct (members n) as [|q' l]; [discriminate Q|].
  injection Q as ->; apply (End q (entry_of n)); [easy | exact Some_ | unfold T; lra].
exists z; split.
  cbn [map concat]; rewrite app_length, plus_INR.
  replace (t + 2 * (INR (length (members b)) + INR (length (concat (map members rest)))) * half - half)
    with (T + 2 * INR (length (concat (map members rest))) * half - half) by (unfold T; ring).
  exact Mz.
intros i s Hs; rewrite Sz; [now apply Sy|].
apply Rle_trans with (1 := Hs); pose proof (pos_INR (length (members b))) as N.
assert (0 <= INR (length (members b)) * half) by (apply Rmult_le_pos; lra); unfold T; lra.
Qed.

Lemma chain_slopes pieces : forall W next,
  chain next W pieces = true -> forall p, In p pieces -> all_slopes p = true.
Proof.
induction pieces as [|q rest IH]; intros W next C p P; [easy|].
destruct P as [<-|P]; [exact (piece_slopes _ _ _ (first_checked program integers _ _ _ _ _ _ _ C))|].
cbn [Checks.check_chain] in C; rewrite !andb_true_iff in C; destruct C as [_ C].
destruct rest as [|r rest]; [easy | exact (IH _ _ C p P)].
Qed.

Lemma blocks_slopes blocks :
  all_checked c blocks -> forall p, In p (concat (map members blocks)) -> all_slopes p = true.
Proof.
induction blocks as [|b rest IH]; intros A p P; [easy|].
destruct A as [C [_ [_ A]]]; apply in_app_or in P; destruct P as [P|P]; [|now apply IH].
exact (chain_slopes _ _ _ C p P).
Qed.
End Frame.

(* The straight line from the initial state with its rates is a motion at time 0. *)
Definition initial (i : nat) : R := let (a, b) := nth i start (0, 1)%Z in IZR a / IZR b.
Definition departure (i : nat) (s : R) : R :=
  initial i + s * field i (map initial (seq 0 count)).

Lemma departure_begins : begins departure.
Proof. intros i _; unfold departure, initial; destruct (nth i start (0, 1)%Z); ring. Qed.

Lemma departure_motion : motion departure 0.
Proof.
intros s Hs i _; replace s with 0 by lra.
replace (state departure 0) with (map initial (seq 0 count)).
  unfold departure; set (f := field i (map initial (seq 0 count))); auto_derive; [easy | ring].
apply map_ext; intros j; unfold departure; ring.
Qed.

Theorem exists_motion c b rest :
  check_start c b = true -> all_checked c (b :: rest) ->
  exists x, motion x (2 * INR (length (concat (map members (b :: rest)))) * half) /\ begins x.
Proof.
intros St A; unfold check_start in St; destruct (members b) as [|q l] eqn:E; [discriminate St|].
rewrite !andb_true_iff in St; destruct St as [[[F T] Below] Low].
destruct (blocks_exist c F (b :: rest) departure half A) as [x [M S]].
- replace (half - half) with 0 by ring; apply departure_motion.
- lra.
- intros q' Q; rewrite E in Q; injection Q as <-.
  left; refine (less_by _ _ _ _ (rational_in (entry_of b)) _ Low).
  apply turned_in; intros j Hj; apply (distance_is_in start); [exact Hj | apply departure_begins | |].
    exact (all_states_spec _ j Below Hj).
  exact (terms_of q j T Hj).
- exists x; split.
    set (n := 2 * INR (length (concat (map members (b :: rest)))) * half) in *.
    now replace n with (half + n - half) by ring.
  intros i Hi; rewrite S by lra; now apply departure_begins.
Qed.

Lemma sum_const n w : sum n (fun _ => w) = INR n * w.
Proof. induction n as [|n IH]; [simpl; ring | cbn [sum]; rewrite IH, S_INR; ring]. Qed.

(* Two motions in the tube of a piece agree in it if they agree at its beginning. *)
Lemma piece_unique p x y until t :
  all_slopes p = true -> motion x until -> motion y until -> half <= t ->
  (forall s, - half <= s <= half -> t + s <= until -> forall i, (i < count)%nat ->
    Rabs (x i (t + s) - candidate p i s) <= error) ->
  (forall s, - half <= s <= half -> t + s <= until -> forall i, (i < count)%nat ->
    Rabs (y i (t + s) - candidate p i s) <= error) ->
  (forall i, (i < count)%nat -> x i (t - half) = y i (t - half)) ->
  forall s, - half <= s <= half -> t + s <= until -> forall i, (i < count)%nat ->
  x i (t + s) = y i (t + s).
Proof.
intros Slopes X Y Ht NX NY Begin s Hs U.
set (e := fun i u => x i (t - half + u) - y i (t - half + u)).
set (de := fun i u => field i (state x (t - half + u)) - field i (state y (t - half + u))).
set (W := fun u => sum count (fun i => e i u * e i u)).
set (dW := fun u => sum count (fun i => 2 * e i u * de i u)).
assert (Gap : forall (z : nat -> R -> R) v, state z (t + v)
    = map (fun j => candidate p j v + (z j (t + v) - candidate p j v)) (seq 0 count)).
  intros z v; apply map_ext; intros j; ring.
assert (Small : W (s + half) <= (W 0 + 0 * (s + half)) * exp (2 * steepness * (s + half))).
  apply (gronwall W dW); [lra | | lra | |].
  - apply Rmult_le_pos; [lra|]; apply Rmult_le_pos; [apply pos_INR | left; apply steepest_positive].
  - intros u Hu; apply (is_derive_sum count (fun i u => e i u * e i u) (fun i u => 2 * e i u * de i u)).
    intros i Hi.
    assert (Shifted : forall z : nat -> R -> R, motion z until ->
      is_derive (fun u => z i (t - half + u)) u (field i (state z (t - half + u)))).
      intros z Z.
      replace (field i (state z (t - half + u))) with (1 * field i (state z (t - half + u))) by ring.
      apply (is_derive_comp (z i) (fun u => t - half + u)); [apply Z; [lra | exact Hi]|].
      auto_derive; [easy | ring].
    assert (D := is_derive_minus _ _ _ _ _ (Shifted x X) (Shifted y Y)).
    replace (2 * e i u * de i u) with (de i u * e i u + e i u * de i u) by ring.
    apply (is_derive_mult (e i) (e i) u _ _ D D); intros; apply Rmult_comm.
  - intros u Hu; unfold dW, W; rewrite Rplus_0_r.
    set (v := u - half); assert (Hv : - half <= v <= half) by (unfold v; lra).
    assert (V : t - half + u = t + v) by (unfold v; ring).
    assert (Uv : t + v <= until) by (unfold v; lra).
    assert (Each : forall i, (i < count)%nat -> 2 * e i u * de i u
      <= IZR steepest * (INR count * (e i u * e i u) + sum count (fun j => e j u * e j u))).
      intros i Hi.
      destruct (field_change program integers p v (fun j => y j (t + v) - candidate p j v)
        (fun j => x j (t + v) - candidate p j v) i Hv) as [g [G E]];
        [intros j Hj; now apply NY | intros j Hj; now apply NX
        | exact (all_states_spec _ i Slopes Hi) |].
      rewrite <- !Gap in E.
      replace (de i u) with (sum count (fun j => g j * e j u)).
        2: { unfold de; rewrite V, E; apply sum_ext; intros j _; unfold e; rewrite V; ring. }
      rewrite <- sum_scal.
      assert (K : forall j, (j < count)%nat -> Rabs (g j) <= IZR steepest).
        intros j Hj; apply (slope_limited p v i j); try easy; intros a; apply G.
      clear - K; induction count as [|n IH]; [simpl; lra|].
      cbn [sum]; rewrite S_INR; specialize (IH (fun j Hj => K j ltac:(lia))); specialize (K n ltac:(lia)).
      apply Rabs_le_between in K.
      assert (2 * e i u * (g n * e n u) <= IZR steepest * (e i u * e i u + e n u * e n u)); [|lra].
      pose proof (Rle_0_sqr (e i u + e n u)) as P; pose proof (Rle_0_sqr (e i u - e n u)) as M.
      unfold Rsqr in P, M.
      assert (0 <= (IZR steepest - g n) * ((e i u + e n u) * (e i u + e n u))) by (apply Rmult_le_pos; lra).
      assert (0 <= (IZR steepest + g n) * ((e i u - e n u) * (e i u - e n u))) by (apply Rmult_le_pos; lra).
      lra.
    apply Rle_trans with (1 := sum_le _ _ _ Each).
    rewrite sum_scal, sum_plus, sum_scal.
    set (w := sum count (fun i => e i u * e i u)).
    rewrite sum_const; unfold steepness; right; ring.
assert (W0 : W 0 = 0).
  unfold W; rewrite (sum_ext _ _ (fun i => 0 * 0)), sum_scal; [ring|].
  intros i Hi; unfold e; replace (t - half + 0) with (t - half) by ring.
  rewrite Begin by exact Hi; ring.
rewrite W0, Rmult_0_l, Rplus_0_r, Rmult_0_l in Small.
intros i Hi; apply Rminus_diag_uniq, Rsqr_0_uniq.
assert (V : t - half + (s + half) = t + s) by ring.
change (W (s + half) <= 0) with (sum count (fun i => e i (s + half) * e i (s + half)) <= 0) in Small.
replace (x i (t + s) - y i (t + s)) with (e i (s + half)) by (unfold e; now rewrite V).
clear - Small Hi; revert Small Hi; generalize count as n; induction n as [|n IH]; intros H Hi; [lia|].
cbn [sum] in H.
assert (0 <= sum n (fun i => e i (s + half) * e i (s + half)))
  by (apply sum_nonneg; intros; apply Rle_0_sqr).
pose proof (Rle_0_sqr (e n (s + half))) as P; unfold Rsqr in P.
destruct (Nat.eq_dec i n) as [->|N]; [unfold Rsqr; lra | apply IH; [lra | lia]].
Qed.

Theorem unique_motion c b rest x y until :
  check_start c b = true -> all_checked c (b :: rest) ->
  motion x until -> motion y until -> begins x -> begins y ->
  forall t, 0 <= t <= until -> t <= 2 * INR (length (concat (map members (b :: rest)))) * half ->
  forall i, (i < count)%nat -> x i t = y i t.
Proof.
intros St A X Y BX BY; pose proof half_positive as H0.
assert (NX := enclosed program integers start c b rest x until St A X BX).
assert (NY := enclosed program integers start c b rest y until St A Y BY).
assert (Slopes := blocks_slopes c (b :: rest) A).
assert (Small := proj2 (accuracy_between c (start_framed start c b St))).
set (pieces := concat (map members (b :: rest))) in *.
assert (All : forall k, (k <= length pieces)%nat -> forall t, 0 <= t <= until -> t <= 2 * INR k * half ->
  forall i, (i < count)%nat -> x i t = y i t); [|intros t Ht L; exact (All _ (le_n _) t Ht L)].
induction k as [|k IH]; intros K t Ht L i Hi.
  replace t with 0 by (simpl in L; lra); now rewrite (BX i Hi), (BY i Hi).
destruct (Rle_dec t (2 * INR k * half)) as [T|T]; [now apply IH; [lia|..]|].
assert (M : middle k - half = 2 * INR k * half) by (unfold middle; ring).
rewrite S_INR in L; pose proof (pos_INR k) as P.
assert (0 <= INR k * half) by (apply Rmult_le_pos; lra).
destruct (nth_error pieces k) as [p|] eqn:E; [|apply nth_error_None in E; lia].
replace t with (middle k + (t - middle k)) by ring.
apply (piece_unique p x y until (middle k)); try easy.
- exact (Slopes p (nth_error_In _ _ E)).
- lra.
- intros s Hs V j Hj; apply Rle_trans with (2 := Small); now apply (NX k p E).
- intros s Hs V j Hj; apply Rle_trans with (2 := Small); now apply (NY k p E).
- rewrite M; intros j Hj; apply IH; [lia | lra | lra | exact Hj].
- lra.
- lra.
Qed.

(* There is exactly one motion for ten seconds, and it is in the tube. *)
Theorem one_motion c b rest :
  check_start c b = true -> all_checked c (b :: rest) ->
  length (concat (map members (b :: rest))) = 160%nat ->
  exists x, motion x 10 /\ begins x /\
  (forall y until, until <= 10 -> motion y until -> begins y ->
   forall t, 0 <= t <= until -> forall i, (i < count)%nat -> y i t = x i t) /\
  forall t, 0 <= t <= 10 -> exists p s, In p (concat (map members (b :: rest))) /\
  - half <= s <= half /\
  forall i, (i < count)%nat -> Rabs (x i t - candidate p i s) <= Q2R (claim c).
Proof.
intros St A N; assert (Ten : 2 * INR 160 * half = 10) by (unfold half; simpl; lra).
destruct (exists_motion c b rest St A) as [x [M B]]; rewrite N, Ten in M.
exists x; split; [exact M | split; [exact B | split]].
- intros y until U Y BY t Ht; apply (unique_motion c b rest y x until St A Y); try easy.
    intros s Hs; apply M; lra.
  rewrite N, Ten; lra.
- apply ten_seconds_covered; [exact (enclosed _ _ _ c b rest x 10 St A M B) | exact N].
Qed.
End Bicycle.

(* Gronwall's inequality, for a function that is known to grow slowly only where it is small. *)
From Coq Require Import Reals Lra Lia.
From Coquelicot Require Import Coquelicot.
Open Scope R_scope.

Lemma near (W : R -> R) (m l eps : R) :
  is_derive W m l -> 0 < eps ->
  exists delta, 0 < delta /\ forall x, Rabs (x - m) < delta -> Rabs (W x - W m) < eps.
Proof.
intros D H.
assert (C : continuous W m) by (apply (ex_derive_continuous W); now exists l).
destruct (C (fun y => Rabs (y - W m) < eps)) as [delta Hd].
  exists (mkposreal eps H); intros y Hy; exact Hy.
exists delta; split; [apply cond_pos | intros x Hx; exact (Hd x Hx)].
Qed.

(* W' <= k W + d gives W(s) <= (W(0) + d s) exp(k s). *)
Lemma gronwall (W dW : R -> R) (s k d : R) :
  0 <= s -> 0 <= k -> 0 <= d ->
  (forall u, 0 <= u <= s -> is_derive W u (dW u)) ->
  (forall u, 0 <= u <= s -> dW u <= k * W u + d) ->
  W s <= (W 0 + d * s) * exp (k * s).
Proof.
intros Hs Hk Hd D H.
destruct (Req_dec s 0) as [->|Hs0].
  rewrite !Rmult_0_r, exp_0; lra.
set (g := fun u => W u * exp (- k * u) - d * u).
set (dg := fun u => (dW u - k * W u) * exp (- k * u) - d).
assert (Dg : forall u, 0 <= u <= s -> is_derive g u (dg u)).
  intros u Hu; unfold g, dg.
  specialize (D u Hu).
  auto_derive; [now exists (dW u)|].
  replace (Derive (fun x => W x) u) with (dW u) by (symmetry; now apply is_derive_unique).
  ring.
destruct (MVT_gen g 0 s dg) as [c [Hc E]].
- intros u Hu; rewrite Rmin_left, Rmax_right in Hu by lra; apply Dg; lra.
- intros u Hu; rewrite Rmin_left, Rmax_right in Hu by lra.
  apply continuity_pt_filterlim, (ex_derive_continuous g).
  exists (dg u); apply Dg; lra.
- rewrite Rmin_left, Rmax_right in Hc by lra.
  assert (N : dg c <= 0).
    unfold dg.
    assert (exp (- k * c) <= 1).
      rewrite <- exp_0.
      assert (0 <= k * c) by (apply Rmult_le_pos; lra).
      destruct (Req_dec (k * c) 0) as [Z|Z].
        replace (- k * c) with 0 by lra; lra.
      left; apply exp_increasing; lra.
    pose proof (exp_pos (- k * c)).
    specialize (H c Hc).
    nra.
  assert (G : g s <= g 0) by nra.
  unfold g in G; rewrite !Rmult_0_r, exp_0 in G.
  assert (B : W s * exp (- k * s) <= W 0 + d * s) by lra.
  replace (W s) with (W s * exp (- k * s) * exp (k * s)).
    apply Rmult_le_compat_r; [left; apply exp_pos | lra].
  rewrite Rmult_assoc, <- exp_plus; replace (- k * s + k * s) with 0 by ring.
  rewrite exp_0; ring.
Qed.

(* The bound stays below the height of the tube up to which the rate is bounded, so it holds. *)
Lemma stays (W dW : R -> R) (s k d bound tube : R) :
  0 <= s -> 0 <= k -> 0 <= d ->
  (forall u, 0 <= u <= s -> is_derive W u (dW u)) ->
  (forall u, 0 <= u <= s -> W u < tube -> dW u <= k * W u + d) ->
  (forall u, 0 <= u <= s -> (W 0 + d * u) * exp (k * u) <= bound) ->
  bound < tube -> W s <= bound.
Proof.
intros Hs Hk Hd D H B T.
assert (Below : forall v, 0 <= v <= s -> (forall u, 0 <= u <= v -> W u < tube) -> W v <= bound).
  intros v Hv A; apply Rle_trans with (2 := B v Hv).
  apply gronwall with dW; try lra; intros u Hu; [apply D | apply H; [|apply A]]; lra.
assert (W0 : W 0 <= bound).
  generalize (B 0 ltac:(lra)); rewrite !Rmult_0_r, exp_0; lra.
set (A := fun u => 0 <= u <= s /\ forall v, 0 <= v <= u -> W v < tube).
assert (A0 : A 0).
  split; [lra | intros v Hv; replace v with 0 by lra; lra].
destruct (completeness A) as [m [Up Least]].
- exists s; intros u [Hu _]; lra.
- now exists 0.
- assert (Hm : 0 <= m <= s).
    split; [now apply Up | apply Least; intros u [Hu _]; lra].
  assert (Before : forall v, 0 <= v < m -> W v < tube).
    intros v Hv; destruct (Rlt_dec (W v) tube) as [|N]; [assumption|].
    assert (m <= v); [|lra].
    apply Least; intros u [Hu Au]; destruct (Rle_dec u v) as [|N']; [assumption|].
    elim N; apply Au; lra.
  assert (Wm : W m <= bound).
    destruct (Rle_dec (W m) bound) as [|N]; [assumption|].
    destruct (Req_dec m 0) as [->|Hm0]; [lra|].
    destruct (near W m (dW m) (W m - bound)) as [delta [Hd' Near]]; [apply D; lra | lra |].
    set (v := Rmax 0 (m - delta / 2)).
    assert (V : 0 <= v < m /\ m - delta / 2 <= v).
      unfold v, Rmax; destruct Rle_dec; lra.
    assert (W v <= bound) by (apply Below; [lra | intros u Hu; apply Before; lra]).
    assert (Q := Near v ltac:(rewrite Rabs_left by lra; lra)).
    apply Rabs_def2 in Q; lra.
  assert (m = s).
    destruct (Req_dec m s) as [|Hms]; [assumption|].
    destruct (near W m (dW m) (tube - W m)) as [delta [Hd' Near]]; [apply D; lra | lra |].
    set (v := Rmin s (m + delta / 2)).
    assert (V : m < v <= s /\ v <= m + delta / 2).
      unfold v, Rmin; destruct Rle_dec; lra.
    assert (v <= m); [|lra].
    apply Up; split; [lra|].
    intros u Hu; destruct (Rlt_dec u m) as [|N]; [apply Before; lra|].
    assert (Q := Near u ltac:(rewrite Rabs_right by lra; lra)).
    apply Rabs_def2 in Q; lra.
  now subst m.
Qed.

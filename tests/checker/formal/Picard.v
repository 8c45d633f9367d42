(* Picard's theorem: differential equations have a solution if their rates are continuous in time and
   satisfy a Lipschitz condition. *)
From Coq Require Import Reals Lra Lia.
From Coquelicot Require Import Coquelicot.
Open Scope R_scope.

(* The number in [a, b] that is nearest to s *)
Definition clamp (a b s : R) : R := Rmax a (Rmin b s).

Lemma clamp_between a b s : a <= b -> a <= clamp a b s <= b.
Proof. intros H; unfold clamp, Rmax, Rmin; repeat destruct Rle_dec; lra. Qed.
Lemma clamp_inside a b s : a <= s <= b -> clamp a b s = s.
Proof. intros H; unfold clamp, Rmax, Rmin; repeat destruct Rle_dec; lra. Qed.
Lemma clamp_near a b s t : Rabs (clamp a b s - clamp a b t) <= Rabs (s - t).
Proof.
unfold clamp, Rmax, Rmin, Rabs; repeat destruct Rle_dec; repeat destruct Rcase_abs; lra.
Qed.

Lemma continuous_clamp a b t : continuous (clamp a b) t.
Proof.
apply filterlim_locally; intros eps; exists eps; intros s S.
apply Rle_lt_trans with (2 := S), clamp_near.
Qed.

(* A uniform limit of continuous functions is continuous. *)
Lemma continuous_limit (f : R -> R) (h : nat -> R -> R) (e : nat -> R) t :
  (forall k s, continuous (h k) s) -> (forall k s, Rabs (f s - h k s) <= e k) ->
  is_lim_seq e 0 -> continuous f t.
Proof.
intros C E L; apply filterlim_locally; intros eps; pose proof (cond_pos eps) as H.
apply is_lim_seq_spec in L.
destruct (L (mkposreal (eps / 4) ltac:(lra))) as [k K]; specialize (K k (le_n k)); simpl in K.
destruct (proj1 (filterlim_locally (h k) (h k t)) (C k t) (mkposreal (eps / 4) ltac:(lra)))
  as [delta N].
exists delta; intros s S; specialize (N s S).
change (Rabs (h k s - h k t) < eps / 4) in N; change (Rabs (f s - f t) < eps).
pose proof (E k s) as A; pose proof (E k t) as B.
apply Rabs_def2 in K; apply Rabs_def2 in N.
apply Rabs_le_between in A; apply Rabs_le_between in B; apply Rabs_def1; lra.
Qed.

(* It is zero if its magnitude is at most a multiple of a sequence that vanishes. *)
Lemma zero_by (x c : R) (e : nat -> R) :
  (forall k, Rabs x <= c * e k) -> is_lim_seq e 0 -> x = 0.
Proof.
intros H L.
assert (A : Rbar_le (Rabs x) (Rbar_mult c 0)).
  apply (is_lim_seq_le (fun _ => Rabs x) (fun k => c * e k)); [exact H | apply is_lim_seq_const|].
  now apply is_lim_seq_scal_l.
simpl in A; rewrite Rmult_0_r in A.
destruct (Req_dec x 0) as [E|E]; [exact E|].
apply Rabs_pos_lt in E; lra.
Qed.

(* The integral of a continuous function *)
Lemma is_RInt_to (f : R -> R) a b : (forall s, continuous f s) -> is_RInt f a b (RInt f a b).
Proof. intros C; apply (RInt_correct f), (ex_RInt_continuous f); intros s _; apply C. Qed.

Lemma is_derive_integral (f : R -> R) a t :
  (forall s, continuous f s) -> is_derive (fun t => RInt f a t) t (f t).
Proof.
intros C; apply (is_derive_RInt f (fun t => RInt f a t) a t); [|apply C].
apply filter_forall; intros s; now apply is_RInt_to.
Qed.

Section Picard.
Variable n : nat. (* of variables *)
Variable g : R -> (nat -> R) -> nat -> R. (* the variables' rates at a time in a state *)
Variables start : nat -> R.
Variables a b L : R. (* the first and the last time, the Lipschitz constant *)
Hypothesis Lpos : 0 < L.
Hypothesis ab : a <= b.
Hypothesis Lipschitz : forall s y z d, (forall j, (j < n)%nat -> Rabs (y j - z j) <= d) ->
  forall i, (i < n)%nat -> Rabs (g s y i - g s z i) <= L * d.
Hypothesis Continuous : forall u : nat -> R -> R,
  (forall j, (j < n)%nat -> forall s, continuous (u j) s) ->
  forall i, (i < n)%nat -> forall s, continuous (fun s => g s (fun j => u j s) i) s.

Definition rate_along (u : nat -> R -> R) (i : nat) (s : R) : R := g s (fun j => u j s) i.
Definition next (u : nat -> R -> R) (i : nat) (t : R) : R :=
  start i + RInt (rate_along u i) a (clamp a b t).
Fixpoint iterate (k : nat) : nat -> R -> R :=
  match k with O => fun i _ => start i | S k => next (iterate k) end.

Definition smooth (u : nat -> R -> R) := forall i, (i < n)%nat -> forall s, continuous (u i) s.

Lemma continuous_next u : smooth u -> smooth (next u).
Proof.
intros C i Hi t; unfold next.
apply (continuous_plus (fun _ => start i)); [apply continuous_const|].
apply (continuous_comp (clamp a b) (fun t => RInt (rate_along u i) a t)); [apply continuous_clamp|].
apply (ex_derive_continuous (fun t => RInt (rate_along u i) a t)).
exists (rate_along u i (clamp a b t)); apply is_derive_integral; now apply Continuous.
Qed.

Lemma continuous_iterate k : smooth (iterate k).
Proof.
induction k as [|k IH]; [intros i _ s; apply continuous_const | now apply continuous_next].
Qed.

(* If two functions differ by at most d, their next ones differ by at most the integral of L d. *)
Lemma next_near u v d D t :
  smooth u -> smooth v ->
  (forall s, a <= s <= b -> forall i, (i < n)%nat -> Rabs (u i s - v i s) <= d s) ->
  is_RInt (fun s => L * d s) a (clamp a b t) D ->
  forall i, (i < n)%nat -> Rabs (next u i t - next v i t) <= D.
Proof.
intros U V H E i Hi; unfold next.
replace (start i + RInt (rate_along u i) a (clamp a b t)
         - (start i + RInt (rate_along v i) a (clamp a b t)))
  with (RInt (rate_along u i) a (clamp a b t) - RInt (rate_along v i) a (clamp a b t)) by ring.
pose proof (clamp_between a b t ab).
apply (norm_RInt_le (fun s => minus (rate_along u i s) (rate_along v i s)) (fun s => L * d s)
  a (clamp a b t)); [lra | | | exact E].
- intros s S; apply (Lipschitz s (fun j => u j s) (fun j => v j s)); [|exact Hi].
  intros j Hj; apply H; [lra | exact Hj].
- apply (is_RInt_minus (rate_along u i) (rate_along v i)); apply is_RInt_to; now apply Continuous.
Qed.

Definition weight (s : R) : R := exp (2 * L * (s - a)).

Lemma weight_integral c t : is_RInt (fun s => L * (c * weight s)) a t (c / 2 * (weight t - 1)).
Proof.
replace (c / 2 * (weight t - 1)) with (minus (c / 2 * weight t) (c / 2 * weight a)).
  apply (is_RInt_derive (fun s => c / 2 * weight s)); intros s _.
    unfold weight; auto_derive; [easy | unfold Rminus; field].
  apply (ex_derive_continuous (fun s => L * (c * weight s))); unfold weight; now auto_derive.
unfold minus, plus, opp, weight; simpl.
replace (2 * L * (a - a)) with 0 by ring; rewrite exp_0; ring.
Qed.

(* Bounds for finitely many variables *)
Lemma common_bound (f : nat -> R -> R) m :
  (forall i, (i < m)%nat -> forall s, continuous (f i) s) ->
  exists M, 0 <= M /\ forall i, (i < m)%nat -> forall s, a <= s <= b -> Rabs (f i s) <= M.
Proof.
induction m as [|m IH]; intros C; [exists 0; split; [lra | intros i Hi; lia]|].
destruct IH as [M [M0 H]]; [intros i Hi; apply C; lia|].
destruct (bounded_continuity (f m) a b) as [N HN]; [intros s _; apply C; lia|].
exists (Rmax M N); split; [apply Rle_trans with (1 := M0), Rmax_l|].
intros i Hi s S; destruct (Nat.eq_dec i m) as [->|E].
  left; apply Rlt_le_trans with (1 := HN s S), Rmax_r.
apply Rle_trans with (2 := Rmax_l M N), H; [lia | exact S].
Qed.

Lemma first_distance : exists c, 0 <= c /\ forall i, (i < n)%nat -> forall t,
  Rabs (iterate 1 i t - iterate 0 i t) <= c.
Proof.
destruct (common_bound (fun i t => iterate 1 i t - iterate 0 i t) n) as [M [M0 H]].
  intros i Hi s; apply (continuous_minus (iterate 1 i) (iterate 0 i)); now apply continuous_iterate.
exists M; split; [exact M0|]; intros i Hi t.
specialize (H i Hi (clamp a b t) (clamp_between a b t ab)).
simpl in *; unfold next in *.
now rewrite (clamp_inside a b (clamp a b t) (clamp_between a b t ab)) in H.
Qed.

Lemma distances c :
  (forall i, (i < n)%nat -> forall t, Rabs (iterate 1 i t - iterate 0 i t) <= c) -> 0 <= c ->
  forall k i, (i < n)%nat -> forall t,
  Rabs (iterate (S k) i t - iterate k i t) <= c / 2 ^ k * weight (clamp a b t).
Proof.
intros First C; induction k as [|k IH]; intros i Hi t.
  apply Rle_trans with (1 := First i Hi t).
  assert (1 <= weight (clamp a b t)).
    unfold weight; rewrite <- exp_0; pose proof (clamp_between a b t ab).
    destruct (Req_dec (clamp a b t) a) as [->|N].
      right; f_equal; ring.
    left; apply exp_increasing, Rmult_lt_0_compat; lra.
  simpl; nra.
assert (P : 0 < 2 ^ k) by (apply pow_lt; lra).
apply Rle_trans with (c / 2 ^ k / 2 * (weight (clamp a b t) - 1)).
  change (iterate (S (S k)) i t) with (next (iterate (S k)) i t).
  change (iterate (S k) i t) with (next (iterate k) i t).
  apply (next_near _ _ (fun s => c / 2 ^ k * weight s)); try apply continuous_iterate;
    [| apply weight_integral | exact Hi].
  intros s S j Hj; specialize (IH j Hj s); now rewrite (clamp_inside a b s S) in IH.
assert (E : c / 2 ^ S k = c / 2 ^ k / 2) by (simpl; field; lra).
rewrite E; apply Rmult_le_compat_l; [|lra].
apply Rmult_le_pos; [apply Rmult_le_pos; [lra | left; now apply Rinv_0_lt_compat] | lra].
Qed.

Lemma weight_most t : weight (clamp a b t) <= weight b.
Proof.
unfold weight; pose proof (clamp_between a b t ab).
destruct (Req_dec (clamp a b t) b) as [->|N]; [lra|].
left; apply exp_increasing, Rmult_lt_compat_l; lra.
Qed.

(* All iterates from k on are near iterate k. *)
Lemma iterates_near : exists c, forall k m i, (i < n)%nat -> forall t,
  Rabs (iterate (m + k) i t - iterate k i t) <= c / 2 ^ k.
Proof.
destruct first_distance as [c0 [C First]].
set (c := c0 * weight b).
assert (W : 0 < weight b) by apply exp_pos.
assert (One : forall k i, (i < n)%nat -> forall t,
  Rabs (iterate (S k) i t - iterate k i t) <= c / 2 ^ k).
  intros k i Hi t; apply Rle_trans with (1 := distances c0 First C k i Hi t); unfold c.
  replace (c0 * weight b / 2 ^ k) with (c0 / 2 ^ k * weight b) by (field; apply pow_nonzero; lra).
  apply Rmult_le_compat_l; [|apply weight_most].
  apply Rmult_le_pos; [lra | left; apply Rinv_0_lt_compat, pow_lt; lra].
assert (C0 : 0 <= c) by (apply Rmult_le_pos; lra).
exists (2 * c); intros k m i Hi t.
assert (H : Rabs (iterate (m + k) i t - iterate k i t) <= 2 * c / 2 ^ k - 2 * c / 2 ^ (m + k)).
  induction m as [|m IH]; [simpl; rewrite Rminus_eq_0, Rabs_R0; lra|].
  replace (iterate (S m + k) i t - iterate k i t) with
    (iterate (S (m + k)) i t - iterate (m + k) i t + (iterate (m + k) i t - iterate k i t))
    by (simpl; ring).
  apply Rle_trans with (1 := Rabs_triang _ _).
  specialize (One (m + k)%nat i Hi t).
  replace (2 * c / 2 ^ (S m + k)) with (c / 2 ^ (m + k)); [lra|].
  simpl; field; apply pow_nonzero; lra.
apply Rle_trans with (1 := H).
assert (0 <= 2 * c / 2 ^ (m + k)); [|lra].
apply Rmult_le_pos; [lra | left; apply Rinv_0_lt_compat, pow_lt; lra].
Qed.

Lemma powers_vanish c : is_lim_seq (fun k => c / 2 ^ k) 0.
Proof.
apply is_lim_seq_ext with (fun k => c * (1 / 2) ^ k).
  intros k; unfold Rdiv; now rewrite Rpow_mult_distr, pow1, Rmult_1_l, pow_inv.
replace (Finite 0) with (Rbar_mult c 0) by (simpl; f_equal; ring).
apply is_lim_seq_scal_l, is_lim_seq_geom; rewrite Rabs_right; lra.
Qed.

Definition limit (i : nat) (t : R) : R := real (Lim_seq (fun k => iterate k i t)).

Lemma limit_near : exists c, forall k i, (i < n)%nat -> forall t,
  Rabs (limit i t - iterate k i t) <= c / 2 ^ k.
Proof.
destruct iterates_near as [c N]; exists c; intros k i Hi t.
assert (Lim : is_lim_seq (fun k => iterate k i t) (limit i t)).
  apply Lim_seq_correct', ex_lim_seq_cauchy_corr; intros eps.
  pose proof (powers_vanish c) as V; apply is_lim_seq_spec in V.
  destruct (V (mkposreal (eps / 2) ltac:(pose proof (cond_pos eps); lra))) as [K HK].
  specialize (HK K (le_n K)); simpl in HK; apply Rabs_def2 in HK.
  exists K; intros p q P Q.
  pose proof (N K (p - K)%nat i Hi t) as A; pose proof (N K (q - K)%nat i Hi t) as B.
  replace (p - K + K)%nat with p in A by lia; replace (q - K + K)%nat with q in B by lia.
  apply Rabs_le_between in A; apply Rabs_le_between in B; apply Rabs_def1; lra.
apply is_lim_seq_incr_n with (N := k) in Lim.
apply Rabs_le_between; split.
- assert (A : Rbar_le (iterate k i t - c / 2 ^ k) (limit i t)).
    apply is_lim_seq_le with (3 := Lim) (u := fun _ => iterate k i t - c / 2 ^ k);
      [|apply is_lim_seq_const].
    intros m; specialize (N k m i Hi t); apply Rabs_le_between in N; lra.
  simpl in A; lra.
- assert (A : Rbar_le (limit i t) (iterate k i t + c / 2 ^ k)).
    apply is_lim_seq_le with (2 := Lim) (v := fun _ => iterate k i t + c / 2 ^ k);
      [|apply is_lim_seq_const].
    intros m; specialize (N k m i Hi t); apply Rabs_le_between in N; lra.
  simpl in A; lra.
Qed.

Lemma continuous_limits : smooth limit.
Proof.
intros i Hi t; destruct limit_near as [c N].
apply (continuous_limit (limit i) (fun k => iterate k i) (fun k => c / 2 ^ k));
  [intros k s; now apply continuous_iterate | intros k s; now apply N | apply powers_vanish].
Qed.

Lemma limit_fixed i t : (i < n)%nat -> limit i t = next limit i t.
Proof.
intros Hi; destruct limit_near as [c N].
apply Rminus_diag_uniq.
apply (zero_by _ (1 + L * (b - a)) (fun k => c / 2 ^ k)); [|apply powers_vanish]; intros k.
pose proof (clamp_between a b t ab) as B.
assert (Near : Rabs (next (iterate k) i t - next limit i t) <= (clamp a b t - a) * (L * (c / 2 ^ k))).
  apply (next_near _ _ (fun _ => c / 2 ^ k));
    [apply continuous_iterate | apply continuous_limits | | | exact Hi].
    intros s _ j Hj; rewrite Rabs_minus_sym; now apply N.
  apply (is_RInt_const a (clamp a b t) (L * (c / 2 ^ k))).
assert (P : 0 <= c / 2 ^ k) by (apply Rle_trans with (2 := N k i Hi t), Rabs_pos).
assert (H : c / 2 ^ S k = c / 2 ^ k / 2) by (simpl; field; apply pow_nonzero; lra).
pose proof (N (S k) i Hi t) as A; simpl iterate in A.
apply Rabs_le_between in A; apply Rabs_le_between in Near.
assert ((clamp a b t - a) * (L * (c / 2 ^ k)) <= (b - a) * (L * (c / 2 ^ k))).
  apply Rmult_le_compat_r; [apply Rmult_le_pos|]; lra.
apply Rabs_le_between; lra.
Qed.

Theorem picard : exists x : nat -> R -> R, (forall i, x i a = start i) /\
  forall t, a <= t <= b -> forall i, (i < n)%nat -> is_derive (x i) t (g t (fun j => x j t) i).
Proof.
exists (fun i t => start i + RInt (rate_along limit i) a t); split.
  intros i; rewrite RInt_point; apply Rplus_0_r.
intros t T i Hi.
assert (E : g t (fun j => start j + RInt (rate_along limit j) a t) i = rate_along limit i t).
  apply Rminus_diag_uniq, (zero_by _ 0 (fun k => 0 / 2 ^ k)); [|apply powers_vanish]; intros k.
  rewrite Rmult_0_l, <- (Rmult_0_r L).
  apply (Lipschitz t); [|exact Hi]; intros j Hj.
  rewrite (limit_fixed j t Hj); unfold next.
  rewrite (clamp_inside a b t T), Rminus_eq_0, Rabs_R0; lra.
rewrite E; replace (rate_along limit i t) with (0 + rate_along limit i t) by ring.
apply (is_derive_plus (fun _ => start i)); [apply (is_derive_const (start i))|].
apply is_derive_integral, Continuous; [apply continuous_limits | exact Hi].
Qed.
End Picard.

(* One function up to a time, and another one after it *)
Definition glued (x y : R -> R) (t s : R) : R := if Rle_dec s t then x s else y s.

Lemma glued_before x y t s : s <= t -> glued x y t s = x s.
Proof. intros H; unfold glued; destruct Rle_dec; [easy | lra]. Qed.
Lemma glued_after x y t s : x t = y t -> t <= s -> glued x y t s = y s.
Proof.
intros E H; unfold glued; destruct Rle_dec; [|easy].
now replace s with t by lra.
Qed.

Lemma is_derive_before x y t s l : s < t -> is_derive x s l -> is_derive (glued x y t) s l.
Proof.
intros H D; apply is_derive_ext_loc with (2 := D).
exists (mkposreal (t - s) ltac:(lra)); intros r Hr; symmetry; apply glued_before.
apply Rabs_def2 in Hr; simpl in Hr; unfold minus, plus, opp in Hr; simpl in Hr; lra.
Qed.
Lemma is_derive_after x y t s l : t < s -> is_derive y s l -> is_derive (glued x y t) s l.
Proof.
intros H D; apply is_derive_ext_loc with (2 := D).
exists (mkposreal (s - t) ltac:(lra)); intros r Hr; unfold glued.
apply Rabs_def2 in Hr; simpl in Hr; unfold minus, plus, opp in Hr; simpl in Hr.
destruct Rle_dec; [lra | easy].
Qed.
(* It has a derivative at this time if the values and the derivatives of both agree there. *)
Lemma is_derive_glued x y t l :
  x t = y t -> is_derive x t l -> is_derive y t l -> is_derive (glued x y t) t l.
Proof.
intros E X Y; apply is_derive_Reals; apply is_derive_Reals in X; apply is_derive_Reals in Y.
intros eps H; destruct (X eps H) as [dx DX]; destruct (Y eps H) as [dy DY].
exists (mkposreal (Rmin dx dy) (Rmin_stable_in_posreal dx dy)); intros h N B; simpl in B.
rewrite (glued_before x y t t) by lra; unfold glued; destruct Rle_dec.
  apply DX; [exact N | apply Rlt_le_trans with (1 := B), Rmin_l].
rewrite E; apply DY; [exact N | apply Rlt_le_trans with (1 := B), Rmin_r].
Qed.

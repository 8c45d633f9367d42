(* The equations of Readable.v are those of Equations.v.

   Each number of Readable.v is the value of a register of the program. Coq searches the program for
   an operation with the same operands. *)
From Coq Require Import Reals List ZArith Lia.
From Interval Require Import Eval.Tree Eval.Prog Eval.Eval.
Require Checks.
Require Import Equations Registers Readable.
Import ListNotations.
Open Scope R_scope.

Section Reading.
Variables x0 x1 x2 x3 x4 x5 x6 : R.
Definition state : list R := [x0; x1; x2; x3; x4; x5; x6].

Definition inputs : list R := state ++ Checks.constants integers.
Definition first : N := 53. (* the register of the first operation, after the inputs *)
Lemma first_register : length inputs = N.to_nat first.
Proof. reflexivity. Qed.

(* x is the value of register k. *)
Definition is (x : R) (k : N) : Prop := x = value equations inputs k.

Lemma is_same x y k : x = y -> is y k -> is x k.
Proof. now intros ->. Qed.
Lemma is_input x k : (N.to_nat k < length inputs)%nat -> register inputs (N.to_nat k) = x -> is x k.
Proof. intros H <-; symmetry; now apply input_value. Qed.
Lemma is_output i x k : output equations first i = Some k -> is x k ->
  nth i (eval_real equations inputs) 0 = x.
Proof. intros F ->; exact (output_found _ _ _ first_register _ _ F). Qed.

Lemma is_unary o x i k : is x i -> find_unary o i equations first = Some k ->
  is (unary_real o x) k.
Proof. unfold is; intros -> F; symmetry; exact (unary_found _ _ _ first_register _ _ _ F). Qed.
Lemma is_neg x i k : is x i -> find_unary Neg i equations first = Some k -> is (- x) k.
Proof. exact (is_unary Neg x i k). Qed.
Lemma is_sin x i k : is x i -> find_unary Sin i equations first = Some k -> is (sin x) k.
Proof. exact (is_unary Sin x i k). Qed.
Lemma is_cos x i k : is x i -> find_unary Cos i equations first = Some k -> is (cos x) k.
Proof. exact (is_unary Cos x i k). Qed.

Lemma is_binary o x y i j k : is x i -> is y j -> find_binary o i j equations first = Some k ->
  is (binary_real o x y) k.
Proof.
unfold is; intros -> -> F; symmetry; exact (binary_found _ _ _ first_register _ _ _ _ F).
Qed.
Lemma is_sub x y i j k : is x i -> is y j ->
  find_binary Sub i j equations first = Some k -> is (x - y) k.
Proof. exact (is_binary Sub x y i j k). Qed.
Lemma is_div x y i j k : is x i -> is y j ->
  find_binary Div i j equations first = Some k -> is (x / y) k.
Proof. exact (is_binary Div x y i j k). Qed.

(* Sums and products in either order *)
Definition either (o : binary_op) i j : option N :=
  match find_binary o i j equations first with
  | Some k => Some k
  | None => find_binary o j i equations first
  end.
Lemma is_either o x y i j k : binary_real o x y = binary_real o y x ->
  is x i -> is y j -> either o i j = Some k -> is (binary_real o x y) k.
Proof.
intros C X Y; unfold either; destruct (find_binary o i j equations first) eqn:F.
- injection 1 as <-; exact (is_binary o x y i j n X Y F).
- intros G; rewrite C; exact (is_binary o y x j i k Y X G).
Qed.
Lemma is_add x y i j k : is x i -> is y j -> either Add i j = Some k -> is (x + y) k.
Proof. exact (is_either Add x y i j k (Rplus_comm x y)). Qed.
Lemma is_mul x y i j k : is x i -> is y j -> either Mul i j = Some k -> is (x * y) k.
Proof. exact (is_either Mul x y i j k (Rmult_comm x y)). Qed.

Lemma r_1 : r = 1.
Proof. unfold r, rR; field. Qed.
Lemma m_1 : m = 1.
Proof. unfold m, unit_mass, mB, mR; field. Qed.

Ltac look_up :=
  lazymatch goal with |- ?f = Some ?k =>
    let found := eval vm_compute in f in
    lazymatch found with Some ?n => unify k n; vm_cast_no_check (eq_refl (Some n)) end
  end.

(* The program omits factors that are one and terms that are zero. *)
Ltac is_zero x := lazymatch x with
  | 0 => idtac | V Roll => idtac | V Steer => idtac
  | ?a * ?b => first [is_zero a | is_zero b] end.
Ltac is_one x := lazymatch x with 1 => idtac | r => idtac | m => idtac | V Hub => idtac end.
Ltac omitted x y := apply (is_same x y); [unfold V; rewrite ?r_1, ?m_1; field|].
Ltac instead x y := apply (is_same x y); [unfold Rdiv; ring|].

Ltac is_integer n :=
  let k := eval vm_compute in (hd 0%N (map snd (filter (fun a => Z.eqb (fst a) n)
    (combine (rev integers) (map N.of_nat (seq 1 (length integers))))))) in
  apply (is_input (IZR n) k); [vm_compute; lia|reflexivity].

(* Find the register of a number. *)
Ltac find_it :=
  lazymatch goal with |- is ?e _ => first
  [ match goal with H : is e ?k |- _ => exact H end
  | lazymatch e with
    | ?a + ?b => first
      [ is_zero a; omitted (a + b) b; find_it
      | is_zero b; omitted (a + b) a; find_it
      | eapply (is_add a b); [find_it|find_it|look_up] ]
    | ?a * ?b => first
      [ is_one a; omitted (a * b) b; find_it
      | is_one b; omitted (a * b) a; find_it
      | eapply (is_mul a b); [find_it|find_it|look_up] ]
    | (?a + ?b * ?x - ?c * ?y + ?d * ?z) / ?n =>
      instead e (a / n + b / n * x - c / n * y + d / n * z); find_it
    | ?a / ?b => first
      [ is_one b; omitted (a / b) a; find_it
      | eapply (is_div a b); [find_it|find_it|look_up] ]
    | ?a - ?b => first
      [ eapply (is_sub a b); [find_it|find_it|look_up]
      | lazymatch b with
        | ?b * ?c * ?d => instead e (a + - (b * c) * d)
        | ?b * ?c => instead e (a + - b * c) end; find_it
      | instead e (a + - b); find_it ]
    | - ?a => eapply (is_neg a); [find_it|look_up]
    | sin ?a => eapply (is_sin a); [find_it|look_up]
    | cos ?a => eapply (is_cos a); [find_it|look_up]
    | IZR ?n => is_integer n
    end
  | fail 1 "The program does not contain" e ] end.

Ltac input x k := assert (is x k) by (apply is_input; [vm_compute; lia|reflexivity]).
Ltac defined x f := let H := fresh in eassert (H : is x _); [unfold f; find_it|].
Ltac define f := lazymatch type of f with
  | R => defined f f
  | list R -> R => defined (f state) f
  | list R -> speed -> R =>
    defined (f state Hub) f; defined (f state Roll) f; defined (f state Steer) f
  | list R -> speed -> speed -> R =>
    defined (f state Hub Hub) f; defined (f state Hub Roll) f; defined (f state Hub Steer) f;
    defined (f state Roll Roll) f; defined (f state Roll Steer) f; defined (f state Steer Steer) f
  end.
Ltac define_all l := lazymatch l with (?l, ?f) => define_all l; define f | ?f => define f end.
Ltac numbers := repeat unfold g, lx, lz, ixx, izz, ixz, i22, J, r, r_f, m_f, lx_f, lz_f, ixx_f,
  izz_f, ixz_f, i22_f, J_f, mass_v, mass_v_f, m, x_rear, z_rear, x_front, z_front, unit_inertia,
  unit_mass, wheel_base, trail, gravity, rR, mR, IRxx, IRyy, xB, zB, mB, IBxx, IByy, IBzz, IBxz, xH,
  zH, mH, IHxx, IHyy, IHzz, IHxz, rF, mF, IFxx, IFyy.
Ltac ratio e x :=
  let H := fresh in eassert (H : is e _); [apply (is_same e x); [numbers; field|find_it]|].

Lemma all_rates i : (i < 7)%nat -> nth i (eval_real equations inputs) 0 = nth i (rates state) 0.
Proof.
input (roll state) 52%N. input (pitch state) 51%N. input (steer state) 50%N.
input (roll_rate state) 49%N. input (steer_rate state) 48%N. input (spin state) 47%N. input PI 0%N.
assert (tenth : tilt = PI * (1 / 10)) by (unfold tilt; field).
eassert (is tilt _) by (rewrite tenth; find_it); clear tenth.
define sl. define cl.
ratio g (327 / 10). ratio (- g) (-327 / 10).
ratio lx (85 / 87). ratio lz (-170 / 87). ratio i22 (34450 / 22707). ratio (J / r) (4 / 261).
ratio ixx (2889487 / 2270700). ratio izz (880487 / 2270700). ratio ixz (2660 / 7569).
ratio (2 * ixz) (5320 / 7569). ratio (ixx - izz) (20090 / 22707).
ratio r_f (7 / 6). ratio m_f (7 / 87). ratio lx_f (-8 / 35). ratio lz_f (-2 / 3).
ratio ixx_f (20471 / 391500). ratio izz_f (60293 / 2740500). ratio ixz_f (-221 / 21750).
ratio (2 * ixz_f) (-221 / 10875). ratio (ixx_f - izz_f) (6917 / 228375).
ratio i22_f (191 / 5075). ratio (J_f / r_f) (8 / 261).
ratio mass_v (265 / 261). ratio mass_v_f (65 / 609).
ratio ((wheel_base + trail) / rR) (11 / 3). ratio (wheel_base / rR) (17 / 5).
ratio (trail / rR) (4 / 15). ratio (r - r_f) (-1 / 6). ratio (r / r_f) (6 / 7).
define_all (l1, l3, i11, i13, i33, l1_f, l3_f, i11_f, i13_f, i33_f, d1, d2, d3, lever1, lever3,
  mass_q, mass_q_f, skew_f, rest_f, beta, sb, cb, s, c, t, Y, tau, kappa, sb_f, cb_f, t_f, e, D,
  q_v, q_1, q_3, x_v, x_1, x_3, y_v, y_1, y_3, ell, g1, c_v, c_1, c_3, divisor, turn, v, turn_rate,
  w1, w3, p, n, nu, q, x, y, w1_f, q_f, w3_f, y_f, v_f, n_f, nu_f, a1, a2, a3, a1_f, a2_f, a3_f,
  along, twist, q_dot, q_f_dot, w1_f_dot, v_f_dot, lateral, beta_dot, turn1, turn3, n_dot, w1_dot,
  w3_dot, W1, W3, W3_f, Q, X_f, Y_f, W1_f, Q_f, V_f, height_f, shift_f, Side, Zeta, Eta, rest_q_f,
  q_more, q_acc, w1_f_acc, q_f_more, q_f_acc, v_f_acc, y_f_acc, height, ahead, arm1, arm3, side, h1,
  h2, h3, arm, f_side, f_q, f_v, f_w1, f_w3, ahead_f, side_f, h1_f, h2_f, h3_f, arm_f, f_side_f,
  f_q_f, f_v_f, f_w1_f, f_w3_f, on_side, on_zeta, on_eta, on_w1_f, on_q_f, m11, m13, m33, on_v,
  on_w1, on_w3, on_q, force, mass, L10, L20, pivot1, mass12, L21, pivot2, z0, z1, z2, steer_acc,
  roll_acc, v_acc).
intros I.
do 7 (destruct i as [|i]; [eapply is_output; [vm_compute; reflexivity|cbn [nth rates]; find_it]|]).
lia.
Qed.
End Reading.

(* For every state the program gives these rates. *)
Theorem readable state i : length state = 7%nat -> (i < 7)%nat ->
  Checks.field equations integers i state = nth i (rates state) 0.
Proof.
intros L; do 8 (destruct state as [|? state]; try discriminate).
apply all_rates.
Qed.

(* So both have the same motions. *)
Theorem same_motions x until : Checks.motion equations integers x until <-> obeys x until.
Proof.
split; intros H t T i I; specialize (H t T i I).
- now rewrite <- readable.
- now rewrite readable.
Qed.

(* What is proved of the program's motions applies to those of the readable equations. *)
Theorem readable_form start (near : (nat -> R -> R) -> Prop) :
  (exists x, Checks.motion equations integers x 10 /\ Checks.begins start x /\
    (forall y until, until <= 10 -> Checks.motion equations integers y until ->
     Checks.begins start y ->
     forall t, 0 <= t <= until -> forall i, (i < Checks.count)%nat -> y i t = x i t) /\ near x) ->
  exists x, obeys x 10 /\ Checks.begins start x /\
    (forall y until, until <= 10 -> obeys y until -> Checks.begins start y ->
     forall t, 0 <= t <= until -> forall i, (i < Checks.count)%nat -> y i t = x i t) /\ near x.
Proof.
intros (x & M & B & U & E); exists x.
split; [exact (proj1 (same_motions x 10) M)|split; [exact B|split; [|exact E]]].
intros y until L O; apply U; [exact L|exact (proj2 (same_motions y until) O)].
Qed.

Print Assumptions readable_form.

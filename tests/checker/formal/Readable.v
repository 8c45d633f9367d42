(* The equations of motion of the benchmark bicycle, in the notation of docs/model.md.

   The suffix _f marks the front assembly. Names that docs/model.md does not explain are those of
   kinematics.py and model.py in heyoka_bike/bicycle/equations. Reading.v proves that these
   equations are the program of Equations.v. *)
From Coq Require Import Reals List.
From Coquelicot Require Import Coquelicot.
Import ListNotations.
Open Scope R_scope.

(* The parameters of Table 1 of Meijaard, Papadopoulos, Ruina and Schwab (2007), in SI units *)
Definition wheel_base := 102 / 100.
Definition trail := 8 / 100.
Definition tilt := PI / 10. (* of the steer axis *)
Definition gravity := 981 / 100.
(* Rear wheel R: radius, mass, inertias *)
Definition rR := 3 / 10.
Definition mR := 2.
Definition IRxx := 603 / 10000.
Definition IRyy := 12 / 100.
(* Rear frame with rider B: centre of mass, mass, inertias *)
Definition xB := 3 / 10.
Definition zB := - (9 / 10).
Definition mB := 85.
Definition IBxx := 92 / 10.
Definition IByy := 11.
Definition IBzz := 28 / 10.
Definition IBxz := 24 / 10.
(* Front fork with handlebar H *)
Definition xH := 9 / 10.
Definition zH := - (7 / 10).
Definition mH := 4.
Definition IHxx := 5892 / 100000.
Definition IHyy := 6 / 100.
Definition IHzz := 708 / 100000.
Definition IHxz := - (756 / 100000).
(* Front wheel F *)
Definition rF := 35 / 100.
Definition mF := 3.
Definition IFxx := 1405 / 10000.
Definition IFyy := 28 / 100.

(* From here on lengths are in units of rR and masses in units of mB + mR. *)
Definition unit_mass := mB + mR.
Definition unit_inertia := unit_mass * rR ^ 2.
Definition g := gravity / rR.

(* The rear assembly: radius, mass, centre of mass from the hub (lx, lz), and inertias about the
   centre of mass in upright axes. J is the axial inertia of the wheel; i22 excludes it. *)
Definition r := rR / rR.
Definition m := (mB + mR) / unit_mass.
Definition x_rear := mB * xB / (mB + mR).
Definition z_rear := (mB * zB + mR * - rR) / (mB + mR).
Definition lx := x_rear / rR.
Definition lz := (z_rear + rR) / rR.
Definition ixx := (IBxx + mB * (zB - z_rear) ^ 2 + IRxx + mR * (- rR - z_rear) ^ 2) / unit_inertia.
Definition izz := (IBzz + mB * (xB - x_rear) ^ 2 + IRxx + mR * (0 - x_rear) ^ 2) / unit_inertia.
Definition ixz := (IBxz - mB * (xB - x_rear) * (zB - z_rear)
  - mR * (0 - x_rear) * (- rR - z_rear)) / unit_inertia.
Definition i22 := (IByy + mB * ((xB - x_rear) ^ 2 + (zB - z_rear) ^ 2)
  + mR * ((0 - x_rear) ^ 2 + (- rR - z_rear) ^ 2)) / unit_inertia.
Definition J := IRyy / unit_inertia.

(* The front assembly *)
Definition r_f := rF / rR.
Definition m_f := (mH + mF) / unit_mass.
Definition x_front := (mH * xH + mF * wheel_base) / (mH + mF).
Definition z_front := (mH * zH + mF * - rF) / (mH + mF).
Definition lx_f := (x_front - wheel_base) / rR.
Definition lz_f := (z_front + rF) / rR.
Definition ixx_f := (IHxx + mH * (zH - z_front) ^ 2 + IFxx + mF * (- rF - z_front) ^ 2)
  / unit_inertia.
Definition izz_f := (IHzz + mH * (xH - x_front) ^ 2 + IFxx + mF * (wheel_base - x_front) ^ 2)
  / unit_inertia.
Definition ixz_f := (IHxz - mH * (xH - x_front) * (zH - z_front)
  - mF * (wheel_base - x_front) * (- rF - z_front)) / unit_inertia.
Definition i22_f := (IHyy + mH * ((xH - x_front) ^ 2 + (zH - z_front) ^ 2)
  + mF * ((wheel_base - x_front) ^ 2 + (- rF - z_front) ^ 2)) / unit_inertia.
Definition J_f := IFyy / unit_inertia.

(* Centre of mass and inertias along e1 and e3, with e3 down the steer axis *)
Definition sl := sin tilt.
Definition cl := cos tilt.
Definition l1 := lx * cl - lz * sl.
Definition l3 := lx * sl + lz * cl.
Definition i11 := ixx * cl * cl - 2 * ixz * sl * cl + izz * sl * sl.
Definition i13 := (ixx - izz) * sl * cl + ixz * (cl * cl - sl * sl).
Definition i33 := ixx * sl * sl + 2 * ixz * sl * cl + izz * cl * cl.
Definition l1_f := lx_f * cl - lz_f * sl.
Definition l3_f := lx_f * sl + lz_f * cl.
Definition i11_f := ixx_f * cl * cl - 2 * ixz_f * sl * cl + izz_f * sl * sl.
Definition i13_f := (ixx_f - izz_f) * sl * cl + ixz_f * (cl * cl - sl * sl).
Definition i33_f := ixx_f * sl * sl + 2 * ixz_f * sl * cl + izz_f * cl * cl.

(* From the rear hub to the steer axis, along the axis, and from the axis to the front hub *)
Definition d1 := (wheel_base + trail) / rR * cl - r * sl.
Definition d2 := wheel_base / rR * sl + (r - r_f) * cl.
Definition d3 := r_f * sl - trail / rR * cl.
(* Distances of the front's centre of mass from the joint, up the axis and ahead of it *)
Definition lever1 := l3_f + d2.
Definition lever3 := l1_f + d3.

(* Effective masses of the hub speed and of rotation about the axle, and a completed square *)
Definition mass_v := m + J / r ^ 2.
Definition mass_q := i22 + m * (l1 * l1 + l3 * l3).
Definition mass_v_f := m_f + J_f / r_f ^ 2.
Definition mass_q_f := i22_f + m_f * (l1_f * l1_f + l3_f * l3_f).
Definition skew_f := i13_f / i33_f.
Definition rest_f := i11_f - i13_f * skew_f.

(* The three independent speeds are the hub speed v, the roll rate and the steer rate. Every speed
   is a row times these three. Rows have capital letters: V is the row of v. *)
Inductive speed := Hub | Roll | Steer.
Definition V (i : speed) := match i with Hub => 1 | _ => 0 end.

Section Rates.
Variable state : list R.
Definition roll := nth 0 state 0.
Definition pitch := nth 1 state 0.
Definition steer := nth 2 state 0.
Definition roll_rate := nth 3 state 0.
Definition steer_rate := nth 4 state 0.
Definition spin := nth 5 state 0.

(* Both wheels on the floor *)
Definition beta := pitch + tilt.
Definition sb := sin beta.
Definition cb := cos beta.
Definition s := sin steer.
Definition c := cos steer.
Definition t := sin roll / cos roll.
Definition Y := c * sb - s * t.
Definition tau := s * sb + c * t.
Definition kappa := (r + d1 * sb - d2 * cb + d3 * Y) / r_f.
Definition sb_f := Y / kappa.
Definition cb_f := cb / kappa.
Definition t_f := tau / kappa.

(* Rolling. The rear frame's rate about its axle is q_v v + q_1 w1 + q_3 w3. The joint's velocity
   along e1 and e2 of the front has the coefficients x_v, x_1, x_3 and y_v, y_1, y_3. *)
Definition e := d2 * Y + d3 * cb.
Definition D := d1 * cb + c * e.
Definition q_v := s / D * (cb * tau).
Definition q_1 := s / D * (e - Y * (r * cb)).
Definition q_3 := - (s / D * (Y * (r * sb + d1))).
Definition x_v := c * cb.
Definition x_1 := s * (r * cb).
Definition x_3 := s * (r * sb + d1).
Definition y_v := - (s * cb).
Definition y_1 := c * (r * cb).
Definition y_3 := c * (r * sb + d1).
Definition ell := r_f * sb_f - d3. (* mechanical trail *)
Definition g1 := r_f * cb_f + d2.
(* The joint's velocity along e2 of the front: c_v v + c_1 w1 + c_3 w3 = ell steer_rate *)
Definition c_v := y_v - g1 * (s * q_v).
Definition c_1 := y_1 - g1 * (c + s * q_1).
Definition c_3 := y_3 - g1 * (s * q_3) - ell.
(* This equation determines the turn rate. *)
Definition divisor := c_3 * cb - c_1 * sb.
Definition turn (i : speed) := match i with
  Hub => - c_v / divisor | Roll => - (c_1 * cb + c_3 * sb) / divisor | Steer => ell / divisor end.

(* All speeds, from the hub speed v, the roll rate and the steer rate *)
Definition v := r * spin.
Definition turn_rate := turn Hub * v + turn Roll * roll_rate + turn Steer * steer_rate.
Definition w1 := cb * roll_rate - sb * turn_rate.
Definition w3 := sb * roll_rate + cb * turn_rate.
Definition p := cb * w1 + sb * w3.
Definition n := cb * w3 - sb * w1.
Definition nu := n * t.
Definition q := q_v * v + q_1 * w1 + q_3 * w3.
Definition x := v * cb.
Definition y := r * p + d1 * w3.
Definition w1_f := c * w1 + s * q.
Definition q_f := c * q - s * w1.
Definition w3_f := w3 + steer_rate.
Definition y_f := c * y - s * x.
Definition v_f := (c * x + s * y + d2 * q_f) / cb_f.
Definition n_f := cb_f * w3_f - sb_f * w1_f.
Definition nu_f := n_f * t_f.

(* Accelerations of the joint at constant v, w1, w3, as a point of the rear and of the front *)
Definition a1 := v * nu * sb - d1 * (q * q) - w3 * y.
Definition a2 := n * (v + r * (q - nu)) + d1 * (q * w1).
Definition a3 := w1 * y - v * nu * cb.
Definition a1_f := v_f * nu_f * sb_f + d3 * (q_f * q_f) - w3_f * y_f.
Definition a2_f := n_f * (v_f + r_f * (q_f - nu_f)) - q_f * (d2 * w3_f + d3 * w1_f).
Definition a3_f := d2 * (q_f * q_f) + w1_f * y_f - v_f * nu_f * cb_f.
(* Because both are equal, the dependent speeds have these rates at constant v, w1, w3. *)
Definition along := c * a1 + s * a2 - a1_f.
Definition twist := steer_rate * w1_f.
Definition q_dot := (cb * (a3 - a3_f) - Y * along + e * twist) / D.
Definition q_f_dot := c * q_dot - twist.
Definition w1_f_dot := s * q_dot + steer_rate * q_f.
Definition v_f_dot := (along + d2 * q_f_dot) / cb_f.
Definition lateral := c * a2 - s * a1 - a2_f.

(* Rates of w1 and w3 at constant v, roll rate and steer rate: the axes e1 and e3 turn, and the turn
   rate changes. *)
Definition beta_dot := q - nu.
Definition turn1 := - (beta_dot * w3).
Definition turn3 := beta_dot * w1.
Definition n_dot := - (c_1 * turn1 + c_3 * turn3 + lateral - g1 * w1_f_dot) / divisor.
Definition w1_dot := turn1 - sb * n_dot.
Definition w3_dot := turn3 + cb * n_dot.

(* Rows *)
Definition W1 (i : speed) := match i with
  Hub => - (sb * turn Hub) | Roll => cb - sb * turn Roll | Steer => - (sb * turn Steer) end.
Definition W3 (i : speed) := match i with
  Hub => cb * turn Hub | Roll => sb + cb * turn Roll | Steer => cb * turn Steer end.
Definition W3_f (i : speed) := match i with Steer => W3 Steer + 1 | i => W3 i end.
Definition Q (i : speed) := q_v * V i + q_1 * W1 i + q_3 * W3 i.
Definition X_f (i : speed) := x_v * V i + x_1 * W1 i + x_3 * W3 i.
Definition Y_f (i : speed) := y_v * V i + y_1 * W1 i + y_3 * W3 i.
Definition W1_f (i : speed) := c * W1 i + s * Q i.
Definition Q_f (i : speed) := c * Q i - s * W1 i.
Definition V_f (i : speed) := (X_f i + d2 * Q_f i) / cb_f.
(* The kinetic energy of the front is a sum of squares of Side, Zeta, Eta and of rotation rates. *)
Definition height_f := m_f * (l3_f * cb_f - l1_f * sb_f).
Definition shift_f := height_f / mass_v_f.
Definition Side (i : speed) := Y_f i + lever3 * W3_f i - lever1 * W1_f i.
Definition Zeta (i : speed) := W3_f i + skew_f * W1_f i.
Definition Eta (i : speed) := V_f i + shift_f * Q_f i.
Definition rest_q_f := mass_q_f - rest_f - shift_f * height_f.

(* Rates of all dependent speeds at constant v, roll rate and steer rate *)
Definition q_more := q_1 * w1_dot + q_3 * w3_dot.
Definition q_acc := q_dot + q_more.
Definition w1_f_acc := w1_f_dot + c * w1_dot + s * q_more.
Definition q_f_more := c * q_more - s * w1_dot.
Definition q_f_acc := q_f_dot + q_f_more.
Definition v_f_acc := v_f_dot + (x_1 * w1_dot + x_3 * w3_dot + d2 * q_f_more) / cb_f.
Definition y_f_acc := lateral + (y_1 * w1_dot + y_3 * w3_dot).

(* Inertia forces minus weight on the rear assembly, if its speeds are constant: along the axle, and
   for q, v, w1 and w3 *)
Definition height := m * (l3 * cb - l1 * sb).
Definition ahead := m * (l1 * cb + l3 * sb).
Definition arm1 := r * cb - l3.
Definition arm3 := r * sb + l1.
Definition side := r * p + l1 * w3 - l3 * w1.
Definition h1 := i11 * w1 + i13 * w3. (* h: angular momentum *)
Definition h2 := i22 * q - J / r * v.
Definition h3 := i13 * w1 + i33 * w3.
Definition arm := l3 * w3 + l1 * w1.
Definition f_side := m * (n * (v + r * (q - nu)) + q * arm - g * sin roll).
Definition f_q := ahead * (v * nu + g * cos roll) - m * side * arm + w3 * h1 - w1 * h3.
Definition f_v := - (ahead * (q * q) + m * side * n).
Definition f_w1 := q * h3 - w3 * h2.
Definition f_w3 := w1 * h2 - q * h1.
(* The same on the front assembly *)
Definition ahead_f := m_f * (l1_f * cb_f + l3_f * sb_f).
Definition side_f := y_f + lever3 * w3_f - lever1 * w1_f.
Definition h1_f := i11_f * w1_f + i13_f * w3_f.
Definition h2_f := i22_f * q_f - J_f / r_f * v_f.
Definition h3_f := i13_f * w1_f + i33_f * w3_f.
Definition arm_f := l3_f * w3_f + l1_f * w1_f.
Definition f_side_f :=
  m_f * (n_f * (v_f + r_f * (q_f - nu_f)) + q_f * arm_f - g * (cos roll * tau)).
Definition f_q_f := ahead_f * (v_f * nu_f + g * (cos roll * kappa)) - m_f * side_f * arm_f
  + w3_f * h1_f - w1_f * h3_f.
Definition f_v_f := - (ahead_f * (q_f * q_f) + m_f * side_f * n_f).
Definition f_w1_f := q_f * h3_f - w3_f * h2_f.
Definition f_w3_f := w1_f * h2_f - q_f * h1_f.

(* Inertia forces minus weight if v, roll rate and steer rate are constant *)
Definition on_side := f_side_f + m_f * y_f_acc + m_f * lever3 * w3_dot - m_f * lever1 * w1_f_acc.
Definition on_zeta := f_w3_f + i33_f * w3_dot + i13_f * w1_f_acc.
Definition on_eta := f_v_f + mass_v_f * v_f_acc + height_f * q_f_acc.
Definition on_w1_f := f_w1_f - skew_f * f_w3_f + rest_f * w1_f_acc.
Definition on_q_f := f_q_f - shift_f * f_v_f + (rest_q_f + rest_f) * q_f_acc.
Definition m11 := m * (arm1 * arm1) + i11.
Definition m13 := m * (arm1 * arm3) + i13.
Definition m33 := m * (arm3 * arm3) + i33.
Definition on_v := f_v + height * q_acc.
Definition on_w1 := f_w1 + arm1 * f_side + c * on_w1_f - s * on_q_f + (m11 * w1_dot + m13 * w3_dot).
Definition on_w3 := f_w3 + arm3 * f_side + (m13 * w1_dot + m33 * w3_dot).
Definition on_q := f_q + s * on_w1_f + c * on_q_f + mass_q * q_acc.

(* Kane's equations: mass times the rates of (v, roll rate, steer rate) plus force is zero. *)
Definition force (i : speed) := V i * on_v + W1 i * on_w1 + W3 i * on_w3 + Q i * on_q
  + Side i * on_side + Zeta i * on_zeta + Eta i * on_eta.
Definition mass (i k : speed) := (m11 + rest_f) * W1 i * W1 k + m13 * (W1 i * W3 k + W3 i * W1 k)
  + m33 * W3 i * W3 k + Side i * (m_f * Side k) + Zeta i * (i33_f * Zeta k)
  + Eta i * (mass_v_f * Eta k) + Q i * ((mass_q + rest_f) * Q k) + Q_f i * (rest_q_f * Q_f k)
  + match i, k with
    | Hub, Hub => mass_v + 2 * (height * Q Hub)
    | Hub, k => height * Q k
    | _, _ => 0
    end.
(* Their solution by mass = L D L^T *)
Definition L10 := mass Hub Roll / mass Hub Hub.
Definition L20 := mass Hub Steer / mass Hub Hub.
Definition pivot1 := mass Roll Roll - L10 * mass Hub Roll.
Definition mass12 := mass Roll Steer - L10 * mass Hub Steer.
Definition L21 := mass12 / pivot1.
Definition pivot2 := mass Steer Steer - L20 * mass Hub Steer - L21 * mass12.
Definition z0 := force Hub.
Definition z1 := force Roll - L10 * z0.
Definition z2 := force Steer - L20 * z0 - L21 * z1.
Definition steer_acc := - (z2 / pivot2).
Definition roll_acc := - (z1 / pivot1 + L21 * steer_acc).
Definition v_acc := - (z0 / mass Hub Hub + L10 * roll_acc + L20 * steer_acc).

(* The rates of roll, pitch, steer, roll rate, steer rate, spin and yaw *)
Definition rates : list R :=
  [roll_rate; beta_dot; steer_rate; roll_acc; steer_acc; v_acc / r; n / cos roll].
End Rates.

(* At each time from 0 to `until` each of the seven state variables has this derivative. *)
Definition obeys (x : nat -> R -> R) (until : R) : Prop :=
  forall t, 0 <= t <= until -> forall i, (i < 7)%nat ->
  is_derive (x i) t (nth i (rates (map (fun i => x i t) (seq 0 7))) 0).

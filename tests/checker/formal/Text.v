(* Lines of the published text are read as decimal numbers and compared with the polynomials. *)
From Coq Require Import Ascii String Reals QArith Qreals ZArith List Bool Lra Lia.
From Coq Require Decimal DecimalString.
Require Import Checks.
Import ListNotations.
Open Scope R_scope.

(* The parts of a text between separators. Joined, the parts are the text again. *)
Fixpoint split (separator : ascii) (s : string) : list string :=
  match s with
  | EmptyString => [EmptyString]
  | String a s =>
    if Ascii.eqb a separator then EmptyString :: split separator s
    else match split separator s with
         | nil => nil
         | part :: parts => String a part :: parts
         end
  end.

Lemma split_whole separator s : String.concat (String separator "") (split separator s) = s.
Proof.
induction s as [|a s IH]; [reflexivity|]; cbn [split].
destruct (split separator s) as [|part parts] eqn:E; [simpl in IH; subst s; discriminate E|].
destruct (Ascii.eqb_spec a separator) as [->|_]; [exact (f_equal (String separator) IH)|].
rewrite <- IH; destruct parts; reflexivity.
Qed.

(* The number i.f * 10^e. Coq's library reads the digits. *)
Definition decimal (i f e : string) : option Q :=
  match DecimalString.NilZero.int_of_string i, DecimalString.NilEmpty.uint_of_string f,
        DecimalString.NilZero.int_of_string e with
  | Some i, Some f, Some e =>
    Some (inject_Z (Z.of_int (Decimal.app_int i f))
          * 10 ^ (Z.of_int e - Z.of_nat (Decimal.nb_digits f)))%Q
  | _, _, _ => None
  end.

Definition read (word : string) : option Q :=
  match map (split ".") (split "e" word) with
  | [[i]] => decimal i "" "0"
  | [[i]; [e]] => decimal i "" e
  | [[i; f]] => decimal i f "0"
  | [[i; f]; [e]] => decimal i f e
  | _ => None
  end.

Fixpoint all_of (found : list (option Q)) : option (list Q) :=
  match found with
  | nil => Some nil
  | Some q :: rest => option_map (cons q) (all_of rest)
  | None :: _ => None
  end.
Definition numbers (line : string) : option (list Q) := all_of (map read (split " " line)).

Example numbers_of_a_line :
  numbers "0.01 -0.50 4 -6.25e-05" = Some [1 # 100; -50 # 100; 4 # 1; -625 # 10000000]%Q.
Proof. reflexivity. Qed.
Example not_a_number : map read ["1,5"; "1.2.3"; "."; "e-05"; ""]%string = repeat None 5.
Proof. reflexivity. Qed.

(* The statement. Line k (from 0) has the time k/100 s and eight columns for each of the maneuvers 1
   to 3: roll angle, roll rate, forward speed, three energies, steer angle and steer rate. *)
Definition wheel_radius : R := 3 / 10. (* of the rear wheel, in metres *)

Definition near_text (x : nat -> R -> R) (until : R) (lines : list string) (maneuver : nat)
    (accuracy : R) :=
  forall k line, nth_error lines k = Some line ->
  exists values, numbers line = Some values /\ length values = 25%nat /\
  let t := Q2R (nth 0 values 0%Q) in
  let column j := Q2R (nth (8 * (maneuver - 1) + j) values 0%Q) in
  t = INR k / 100 /\
  (t <= until ->
    Rabs (x 0%nat t - column 1%nat) <= accuracy /\ (* roll angle *)
    Rabs (x 3%nat t - column 2%nat) <= accuracy /\ (* its rate *)
    Rabs (wheel_radius * x 5%nat t - column 3%nat) <= wheel_radius * accuracy /\ (* speed *)
    Rabs (x 2%nat t - column 7%nat) <= accuracy /\ (* steer angle *)
    Rabs (x 4%nat t - column 8%nat) <= accuracy). (* its rate *)

(* The checks, in exact integers. The value of a polynomial at n/800 s is the first number, over
   2^80 times the second one. *)
Fixpoint value_at (n : Z) (c : list Z) : Z * Z :=
  match c with
  | nil => (0, 1)%Z
  | a :: c => let (v, u) := value_at n c in (a * (800 * u) + n * v, 800 * u)%Z
  end.

(* The largest difference between a number of the text and its polynomial *)
Definition reading : R := 1 / 100000000000000.

(* True if the value of variable i is within 1e-14 of the number. *)
Definition is_near (p : piece) (n : Z) (i : nat) (q : Q) : bool :=
  let (v, u) := value_at n (nth i (coefficients p) nil) in
  let below := (u * 2 ^ grid)%Z in
  let den := Zpos (Qden q) in
  Z.leb (Z.abs (v * den - Qnum q * below) * 100000000000000) (below * den).

(* A time at the break of two pieces belongs to the first of them. *)
Definition check_line (pieces : list piece) (maneuver k : nat) (line : string) : bool :=
  let m := ((4 * k - 1) / 25)%nat in
  let n := (8 * Z.of_nat k - 25 * (2 * Z.of_nat m + 1))%Z in
  match numbers line, nth_error pieces m with
  | Some values, Some p =>
    let column j := nth (8 * (maneuver - 1) + j) values 0%Q in
    Nat.eqb (length values) 25 && Z.leb (Z.abs n) 25
    && Qeq_bool (nth 0 values 0%Q) (Z.of_nat k # 100)
    && is_near p n 0 (column 1%nat) && is_near p n 3 (column 2%nat)
    && is_near p n 5 (column 3%nat * (10 # 3))%Q
    && is_near p n 2 (column 7%nat) && is_near p n 4 (column 8%nat)
  | _, _ => false
  end.

Fixpoint check_from (pieces : list piece) (maneuver k : nat) (lines : list string) : bool :=
  match lines with
  | nil => true
  | line :: rest => check_line pieces maneuver k line && check_from pieces maneuver (S k) rest
  end.
Definition check_text (pieces : list piece) (maneuver : nat) (lines : list string) : bool :=
  check_from pieces maneuver 0 lines.

(* The checks suffice. *)
Lemma value_at_positive n c : (0 < snd (value_at n c))%Z.
Proof.
induction c as [|a c IH]; cbn [value_at]; [reflexivity|].
destruct (value_at n c); cbn [snd] in *; lia.
Qed.

Lemma value_at_correct n c :
  polynomial c (IZR n / 800) = IZR (fst (value_at n c)) / IZR (snd (value_at n c) * 2 ^ grid).
Proof.
induction c as [|a c IH]; cbn [polynomial value_at]; [simpl; lra|].
pose proof (value_at_positive n c) as P; apply IZR_lt in P; rewrite IH; unfold over, grid.
destruct (value_at n c) as [v u]; cbn [fst snd] in *.
rewrite plus_IZR, !mult_IZR; field; lra.
Qed.

Lemma is_near_correct p n i q : is_near p n i q = true ->
  Rabs (candidate p i (IZR n / 800) - Q2R q) <= reading.
Proof.
unfold is_near, candidate, reading, Q2R; intros H; rewrite value_at_correct.
pose proof (value_at_positive n (nth i (coefficients p) nil)) as P.
destruct (value_at n (nth i (coefficients p) nil)) as [v u]; cbn [fst snd] in *.
set (below := (u * 2 ^ grid)%Z) in *; assert (B : (0 < below)%Z) by (unfold below, grid; lia).
apply Z.leb_le, IZR_le in H; apply IZR_lt in B.
rewrite !mult_IZR, abs_IZR, minus_IZR, !mult_IZR in H.
assert (D : 0 < IZR (Zpos (Qden q))) by (apply IZR_lt; reflexivity).
replace (IZR v / IZR below - IZR (Qnum q) * / IZR (Zpos (Qden q)))
  with ((IZR v * IZR (Zpos (Qden q)) - IZR (Qnum q) * IZR below)
        * / (IZR below * IZR (Zpos (Qden q)))) by (field; lra).
assert (M : 0 < IZR below * IZR (Zpos (Qden q))) by now apply Rmult_lt_0_compat.
rewrite Rabs_mult, (Rabs_right (/ _)) by (apply Rle_ge, Rlt_le, Rinv_0_lt_compat, M).
apply Rmult_le_reg_r with (IZR below * IZR (Zpos (Qden q))); [exact M|].
rewrite Rmult_assoc, Rinv_l by lra; lra.
Qed.

Lemma check_from_spec pieces maneuver lines : forall k, check_from pieces maneuver k lines = true ->
  forall j line, nth_error lines j = Some line -> check_line pieces maneuver (k + j) line = true.
Proof.
induction lines as [|l lines IH]; intros k C j line L; [destruct j; discriminate L|].
cbn [check_from] in C; apply andb_true_iff in C; destruct C as [C R], j as [|j].
  injection L as <-; now rewrite Nat.add_0_r.
rewrite Nat.add_succ_r; exact (IH (S k) R j line L).
Qed.

Theorem published x until pieces maneuver lines accuracy text_accuracy :
  accuracy + reading <= text_accuracy -> check_text pieces maneuver lines = true -> near_candidate x until pieces accuracy ->
  near_text x until lines maneuver text_accuracy.
Proof.
intros Wide C Near k line L; apply (check_from_spec _ _ _ 0) with (2 := L) in C.
unfold check_line in C; rewrite Nat.add_0_l in C; set (m := ((4 * k - 1) / 25)%nat) in *.
set (n := (8 * Z.of_nat k - 25 * (2 * Z.of_nat m + 1))%Z) in *.
destruct (numbers line) as [values|]; [|discriminate C].
destruct (nth_error pieces m) as [p|] eqn:P; [|discriminate C].
rewrite !andb_true_iff in C; destruct C as [[[[[[[N S] T] C1] C2] C3] C4] C5].
exists values; split; [reflexivity | split; [now apply Nat.eqb_eq|]]; cbv zeta.
assert (E : Q2R (nth 0 values 0%Q) = INR k / 100).
  apply Qeq_bool_iff, Qeq_eqR in T; rewrite T, INR_IZR_INZ; reflexivity.
rewrite E; split; [reflexivity | intros U].
assert (M : INR k / 100 = middle m + IZR n / 800).
  unfold middle, half, n; rewrite minus_IZR, !mult_IZR, plus_IZR, mult_IZR, <- !INR_IZR_INZ; field.
assert (In : - half <= IZR n / 800 <= half).
  apply Z.leb_le, Z.abs_le in S; destruct S as [S1 S2].
  apply IZR_le in S1, S2; rewrite opp_IZR in S1; unfold half; lra.
rewrite M in *; clear M.
assert (Each : forall i q, (i < count)%nat -> is_near p n i q = true ->
    Rabs (x i (middle m + IZR n / 800) - Q2R q) <= text_accuracy).
  intros i q Hi C; apply is_near_correct in C.
  pose proof (Near m p P _ In U i Hi) as V; clear - Wide C V.
  revert C V; unfold Rabs; repeat destruct Rcase_abs; lra.
repeat split; try (apply Each; [unfold count; lia | assumption]).
apply Each in C3; [|unfold count; lia]; rewrite Q2R_mult in C3.
match goal with |- Rabs (_ - ?c) <= _ => set (column := c) in * end.
replace (wheel_radius * x 5%nat (middle m + IZR n / 800) - column)
  with (wheel_radius * (x 5%nat (middle m + IZR n / 800) - column * Q2R (10 # 3)))
  by (unfold wheel_radius, Q2R; simpl; field).
rewrite Rabs_mult, (Rabs_right wheel_radius) by (unfold wheel_radius; lra).
apply Rmult_le_compat_l; [unfold wheel_radius; lra | exact C3].
Qed.

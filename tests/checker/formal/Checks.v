(* Theorem 1 for polynomials in one bicycle: what a motion is, the checks, and why they suffice. *)
From Coq Require Import Reals QArith Qreals ZArith List Bool Lra Lia.
From Coquelicot Require Import Coquelicot.
From Interval Require Import Xreal Interval.Interval Float_full Tactic_float.
From Interval Require Import Eval.Tree Eval.Prog Eval.Eval.
Require Import Growth Sums Intervals Models Fine Wide Slopes Squares.
Require Export Polynomials.
Import ListNotations.
Open Scope R_scope.

Definition count := 7%nat. (* of state variables *)

(* Coefficients are integers over 2^80, by variable, the constant one first, in time from the
   middle of a piece; its growth rate is an integer over 2^10. *)
Record piece := Piece { coefficients : list (list Z); rate : Z }.

(* The error is the frame times coordinates; the sum of their squares stays below the tube. There
   every variable differs from its polynomial by at most the claim. *)
Record certificate :=
  Certificate { frame : list (list Q); inverse : list (list Q); tube : Q; claim : Q }.

(* Pieces that one computation checks; the sum of squares at their beginning is at most the entry. *)
Record block := Block { entry_of : Q; members : list piece }.

Definition candidate (p : piece) (i : nat) := polynomial (nth i (coefficients p) nil).

Definition half : R := 1 / 32. (* of the length of a piece, in seconds *)
Definition middle (k : nat) : R := (2 * INR k + 1) * half.
Definition error : R := 1 / 100000000. (* of the states for which slopes are enclosed *)

Section Bicycle.
Variable program : list term.
Variable integers : list Z.
Variable start : list (Z * Z).

Definition constants : list R := map IZR integers ++ [PI].

(* The right-hand side of the equations of motion. *)
Definition field (i : nat) (x : list R) : R := nth i (eval_real program (x ++ constants)) 0.

Definition state (x : nat -> R -> R) (t : R) : list R := map (fun i => x i t) (seq 0 count).

Definition motion (x : nat -> R -> R) (until : R) : Prop :=
  forall t, 0 <= t <= until -> forall i, (i < count)%nat ->
  is_derive (x i) t (field i (state x t)).

Definition begins (x : nat -> R -> R) : Prop :=
  forall i, (i < count)%nat -> x i 0 = let (a, b) := nth i start (0, 1)%Z in IZR a / IZR b.

(* The conclusion of Theorem 1. *)
Definition near_candidate (x : nat -> R -> R) (until : R) (pieces : list piece) (accuracy : R) :=
  forall k p, nth_error pieces k = Some p ->
  forall s, - half <= s <= half -> middle k + s <= until ->
  forall i, (i < count)%nat -> Rabs (x i (middle k + s) - candidate p i s) <= accuracy.

(* The checks, in intervals of binary64 and in exact numbers. *)

Definition scaled (n bits : Z) : I.type := I.div prec (integer n) (integer (2 ^ bits)).
Definition rational (q : Q) : I.type := I.div prec (integer (Qnum q)) (integer (Zpos (Qden q))).
Definition length_in : I.type := I.div prec (integer 1) (integer 16).
Definition span : I.type := stretch (-1) 1 32.
Definition symmetric (a : I.type) : I.type := I.join (I.neg a) a.
Definition constants_in : list I.type := map integer integers ++ [I.pi prec].
Definition all_states (f : nat -> bool) : bool := forallb f (seq 0 count).

Definition number (m : list (list Q)) i j : Q := nth j (nth i m nil) 0%Q.
Definition matrix_in (m : list (list Q)) : list (list I.type) :=
  table count (fun i j => rational (number m i j)).
Definition product (a b : list (list I.type)) : list (list I.type) :=
  table count (fun i j => interval_sum count (fun k => I.mul prec (entry a i k) (entry b k j))).
(* The sum of squares of a matrix times a vector *)
Definition squares_in (a : list (list I.type)) (v : nat -> I.type) : I.type :=
  interval_sum count (fun i =>
    I.sqr prec (interval_sum count (fun k => I.mul prec (entry a i k) (v k)))).

Fixpoint models (u : TM.U) (c : list Z) : TM.T * TM.T :=
  match c with
  | nil => (TM.const I.zero, TM.const I.zero)
  | a :: c => let (p, d) := models u c in
    (TM.add u span (TM.const (scaled a grid)) (TM.mul u span TM.var p),
     TM.add u span p (TM.mul u span TM.var d))
  end.
Definition models_of (u : TM.U) (p : piece) (i : nat) := models u (nth i (coefficients p) nil).

(* How far the derivatives of the candidate are from the rates along it: models in binary64, and
   values at five times in wide intervals, between which the models have small remainders. *)
Definition fine : TM.U := (prec, 18%nat).
Definition rates_of (inputs : list (TM.T * TM.T)) : list TM.T :=
  eval_generic TM.dummy (fine_operations fine span) program
    (map fst inputs ++ map TM.const constants_in).
Definition missing_models (p : piece) : list TM.T :=
  let inputs := map (models_of fine p) (seq 0 count) in
  let rates := rates_of inputs in
  map (fun i => TM.sub fine span (snd (nth i inputs (TM.dummy, TM.dummy))) (nth i rates TM.dummy))
    (seq 0 count).
Definition rows (p : piece) : list (list Z) := map (fun i => nth i (coefficients p) nil) (seq 0 count).
Definition missing_at (rows : list (list W.type)) (j : Z) : list I.type :=
  let s := wide_fraction j 64 in
  let rates := wide_rates program integers rows s in
  map (fun i => wide_defect rates (nth i rows nil) s i) (seq 0 count).
Definition missing (p : piece) : list I.type :=
  let models := missing_models p in
  let rows := map wide_coefficients (rows p) in
  let values := map (missing_at rows) nodes in
  map (fun i => between (remainder span (nth i models TM.dummy)) (map (fun l => nth i l I.nai) values))
    (seq 0 count).
Definition missing_squares (back : list (list I.type)) (p : piece) : I.type :=
  let m := missing p in squares_in back (fun i => nth i m I.nai).
(* A little more than the upper end of an interval that begins with 0 *)
Definition above (a : I.type) : I.type :=
  A.J.midpoint (I.add prec (I.mul prec (scaled 2049 10) a) (scaled 1 150)).

(* The slopes of the rates over the states in the tube around the candidate. *)
Definition coarse : TM.U := (prec, 5%nat).
Definition room : I.type := symmetric (I.div prec (integer 1) (integer 100000000)).
Definition unit_slopes (i : nat) : list slope := repeat None i ++ [Some (TM.const (integer 1))].
Definition boxes_of (p : piece) : list sloped :=
  map (fun i => Some (TM.add coarse span (fst (models_of coarse p i)) (TM.const room),
                      unit_slopes i)) (seq 0 count)
  ++ map (fun c => Some (TM.const c, nil)) constants_in.
Definition slopes_found (p : piece) : list sloped :=
  eval_generic None (sloped_operations coarse span) program (boxes_of p).
Definition slope_at (a : sloped) (j : nat) (s : I.type) : I.type :=
  match a with
  | Some (_, p) => match nth j p None with Some m => value span m s | None => I.zero end
  | None => I.nai
  end.
(* The slopes are known, and their magnitudes are less than this limit. *)
Definition steepest : Z := 2 ^ 10.
Definition is_gentle (a : I.type) : bool :=
  is_positive (I.sub prec (integer steepest) a) && is_positive (I.add prec (integer steepest) a).
Definition has_slopes (a : sloped) : bool :=
  match a with Some _ => all_states (fun j => is_gentle (slope_at a j span)) | None => false end.

(* A piece is cut into parts, over each of which squares of errors grow at most at the rate. *)
Definition parts := 16%nat.
Definition part (q : nat) : I.type := stretch (Z.of_nat q - 8) (Z.of_nat q - 7) 256.
Definition check_part (out back : list (list I.type)) (k : I.type) (found : list sloped) (q : nat) :=
  let s := part q in
  let b := product back (product (table count (fun i j => slope_at (nth i found None) j s)) out) in
  nonnegative count (table count (fun i j =>
    if Nat.eqb i j then I.sub prec k (I.mul prec (integer 2) (entry b i i))
    else I.neg (I.add prec (entry b i j) (entry b j i)))).
Definition terms := 19%nat.
Definition has_terms (p : piece) : bool :=
  all_states (fun i => Nat.eqb (length (nth i (coefficients p) nil)) terms).
Definition check_piece (out back : list (list I.type)) (p : piece) : bool :=
  let found := slopes_found p in
  let k := scaled (rate p) 10 in
  all_states (fun i => has_slopes (nth i found None))
  && has_terms p
  && Z.leb 0 (rate p)
  && forallb (check_part out back k found) (seq 0 parts).

(* The bound at the end of a piece: squares w at its beginning, and a defect of squares d. *)
Definition ratio (w d : I.type) : I.type :=
  I.sqrt prec (I.div prec d (I.add prec w (I.mul prec d (I.sqr prec length_in)))).
Definition bound (k w d : I.type) : I.type :=
  let r := ratio w d in
  I.mul prec (I.add prec w (I.mul prec (I.div prec d r) length_in))
    (I.exp prec (I.mul prec (I.add prec k r) length_in)).

(* A polynomial's value at an end of its piece, times 2^80 and a power of 32. *)
Fixpoint end_of (sign : Z) (c : list Z) : Z :=
  match c with nil => 0 | a :: c => a * 32 ^ (1 + Z.of_nat (length c)) + sign * end_of sign c end%Z.
Definition unity : Z := 2 ^ 175. (* 2^80 32^19 *)
Definition jump_in (p q : piece) (i : nat) : I.type :=
  I.div prec (integer (end_of 1 (nth i (coefficients p) nil) - end_of (-1) (nth i (coefficients q) nil)))
    (integer unity).
Definition share (w j : I.type) : I.type :=
  let j := I.add prec j (scaled 1 200) in I.sqrt prec (I.div prec j (I.add prec w j)).
Definition after_jump (w j : I.type) : I.type :=
  let r := share w j in
  I.add prec (I.mul prec (I.add prec (integer 1) r) w)
    (I.mul prec (I.add prec (integer 1) (I.inv prec r)) j).

Definition distance_in (p : piece) (i : nat) : I.type :=
  let (a, b) := nth i start (0, 1)%Z in
  I.div prec (integer (a * unity - b * end_of (-1) (nth i (coefficients p) nil))) (integer (b * unity)).

(* The last piece is followed by the next one, where the sum of squares is at most the number given. *)
Fixpoint check_chain (out back : list (list I.type)) (limit : I.type) (next : option (piece * Q))
    (w : I.type) (pieces : list piece) : bool :=
  match pieces with
  | nil => true
  | p :: rest =>
    let s := missing_squares back p in
    let d := above s in
    let w := bound (scaled (rate p) 10) w d in
    check_piece out back p && is_positive (I.sub prec d s) && is_positive d
    && is_positive (I.sub prec limit w)
    && match rest with
       | nil =>
         match next with
         | None => true
         | Some (q, e) => has_terms q
           && is_positive (I.sub prec (rational e) (after_jump w (squares_in back (jump_in p q))))
         end
       | q :: _ =>
         check_chain out back limit next (after_jump w (squares_in back (jump_in p q))) rest
       end
  end.

Fixpoint qsum (n : nat) (f : nat -> Q) : Q := match n with O => 0 | S m => qsum m f + f m end%Q.
Definition is_inverse (c : certificate) (i k : nat) : bool :=
  Qeq_bool (qsum count (fun j => number (frame c) i j * number (inverse c) j k)%Q)
    (if Nat.eqb k i then 1 else 0)%Q.
Definition is_low (c : certificate) (i : nat) : bool :=
  Qle_bool (qsum count (fun j => number (frame c) i j * number (frame c) i j)%Q * tube c)%Q
    (claim c * claim c)%Q.
Strategy 1000 [Qeq_bool Qle_bool qsum].
Definition check_frame (c : certificate) : bool :=
  all_states (fun i => all_states (is_inverse c i)) && all_states (is_low c)
  && Qle_bool 0 (claim c) && Qle_bool (claim c) (1 # 100000000).

(* The first piece begins near the initial state. *)
Definition check_start (c : certificate) (b : block) : bool :=
  match members b with
  | nil => false
  | p :: _ => check_frame c && has_terms p
    && all_states (fun i => Z.ltb 0 (snd (nth i start (0, 1)%Z)))
    && is_positive (I.sub prec (rational (entry_of b))
         (squares_in (matrix_in (inverse c)) (distance_in p)))
  end.

Definition first_of (b : block) : option (piece * Q) :=
  match members b with nil => None | p :: _ => Some (p, entry_of b) end.
Definition check_block (c : certificate) (b : block) (next : option block) : bool :=
  check_chain (matrix_in (frame c)) (matrix_in (inverse c)) (rational (tube c))
    (match next with None => None | Some b => first_of b end) (rational (entry_of b)) (members b).
End Bicycle.

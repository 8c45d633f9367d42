(* The value of each operation of a program, by its number, and a search for operations. *)
From Coq Require Import Reals List ZArith Lia.
From Interval Require Import Eval.Tree Eval.Prog Eval.Eval.
Import ListNotations.
Open Scope R_scope.

(* Register k is the entry k of the stack, counted from its bottom. *)
Definition register (stack : list R) (k : nat) : R := nth k (rev stack) 0.

Definition result (t : term) (operand : nat -> R) : R :=
  match t with
  | Forward u => operand u
  | Unary o u => unary_real o (operand u)
  | Binary o u v => binary_real o (operand u) (operand v)
  end.
Definition reaches (t : term) (n : nat) : Prop :=
  match t with
  | Forward u | Unary _ u => (u < n)%nat
  | Binary _ u v => (u < n)%nat /\ (v < n)%nat
  end.

Lemma register_pushed stack x k :
  (k < length stack)%nat -> register (x :: stack) k = register stack k.
Proof. intros; unfold register; cbn; rewrite app_nth1; auto; rewrite rev_length; lia. Qed.

Lemma register_top stack x : register (x :: stack) (length stack) = x.
Proof.
unfold register; cbn; rewrite app_nth2; rewrite rev_length; [|lia].
now rewrite Nat.sub_diag.
Qed.

Lemma register_kept program : forall stack k, (k < length stack)%nat ->
  register (eval_real program stack) k = register stack k.
Proof.
induction program as [|t program IH]; intros stack k H; auto.
cbn [eval_real eval_generic fold_left]; unfold eval_real, eval_generic in *; cbn.
rewrite IH; [|cbn; lia]; now apply register_pushed.
Qed.

Lemma stack_length program : forall stack,
  length (eval_real program stack) = (length stack + length program)%nat.
Proof.
induction program as [|t program IH]; intros stack; cbn; [lia|].
unfold eval_real, eval_generic in *; rewrite IH; cbn; lia.
Qed.

Lemma nth_register stack u : (u < length stack)%nat ->
  nth u stack 0 = register stack (length stack - 1 - u).
Proof.
intros H; unfold register; rewrite rev_nth; [|lia]; f_equal; lia.
Qed.

(* The result of an operation is in its register when the program ends, and so are its operands. *)
Lemma register_result program : forall stack m t, nth_error program m = Some t ->
  reaches t (length stack + m) ->
  register (eval_real program stack) (length stack + m)
  = result t (fun u => register (eval_real program stack) (length stack + m - 1 - u)).
Proof.
induction program as [|t0 program IH]; intros stack m t H W; [now destruct m|].
change (eval_real (t0 :: program) stack)
  with (eval_real program (eval_generic_body 0 real_operations stack t0)).
destruct m as [|m].
- injection H as <-.
  rewrite Nat.add_0_r in *.
  rewrite register_kept by (cbn; lia).
  unfold eval_generic_body at 1.
  rewrite register_top.
  assert (K : forall u, (u < length stack)%nat -> nth u stack 0 =
    register (eval_real program (eval_generic_body 0 real_operations stack t0))
      (length stack - 1 - u)).
  { intros u L; rewrite register_kept by (cbn; lia).
    unfold eval_generic_body; rewrite register_pushed by lia; now apply nth_register. }
  destruct t0; cbn in W |- *; rewrite ?K by lia; auto.
- set (pushed := eval_generic_body 0 real_operations stack t0).
  replace (length stack + Datatypes.S m)%nat with (length pushed + m)%nat in *
    by (unfold pushed, eval_generic_body; cbn; lia).
  now apply IH.
Qed.

(* A search for an operation with these operands, from register n on *)
Definition same_unary (o o' : unary_op) : bool :=
  match o, o' with Neg, Neg | Sin, Sin | Cos, Cos => true | _, _ => false end.
Definition same_binary (o o' : binary_op) : bool :=
  match o, o' with Add, Add | Sub, Sub | Mul, Mul | Div, Div => true | _, _ => false end.

Definition is_operand (n : N) (u : nat) (i : N) : bool := N.eqb (N.of_nat u + i + 1) n.

Fixpoint find (is_it : N -> term -> bool) (program : list term) (n : N) : option N :=
  match program with
  | nil => None
  | t :: program => if is_it n t then Some n else find is_it program (N.succ n)
  end.
Definition is_unary o i n t := match t with
  Unary o' u => same_unary o o' && is_operand n u i | _ => false end%bool.
Definition is_binary o i k n t := match t with
  Binary o' u v => same_binary o o' && is_operand n u i && is_operand n v k | _ => false end%bool.
Definition find_unary o i := find (is_unary o i).
Definition find_binary o i k := find (is_binary o i k).

Lemma find_sound is_it program : forall n k, find is_it program n = Some k -> exists m t,
  nth_error program m = Some t /\ is_it k t = true /\ N.to_nat k = (N.to_nat n + m)%nat.
Proof.
induction program as [|t program IH]; intros n k; cbn; [discriminate|].
destruct (is_it n t) eqn:H.
- injection 1 as <-; exists O, t; repeat split; auto; lia.
- intros F; destruct (IH _ _ F) as (m & t' & A & B & C).
  exists (Datatypes.S m), t'; repeat split; auto; lia.
Qed.

Section Values.
Variable program : list term.
Variable inputs : list R.
Variable first : N. (* the register of the first operation *)
Hypothesis first_register : length inputs = N.to_nat first.

(* The register whose value is entry i of the stack at the end *)
Definition output (i : nat) : option N :=
  let m := (length program - 1 - i)%nat in
  match nth_error program m with
  | Some (Forward u) =>
    if (Nat.ltb i (length program) && N.ltb (N.of_nat u) (first + N.of_nat m))%bool
    then Some (first + N.of_nat m - 1 - N.of_nat u)%N else None
  | _ => None
  end.

Definition value (k : N) : R := register (eval_real program inputs) (N.to_nat k).

Lemma operand n u i m : is_operand n u i = true -> N.to_nat n = (length inputs + m)%nat ->
  (u < length inputs + m)%nat /\
  register (eval_real program inputs) (length inputs + m - 1 - u) = value i.
Proof.
unfold is_operand, value; rewrite N.eqb_eq; intros; split; [lia|f_equal; lia].
Qed.

Lemma unary_found o i k : find_unary o i program first = Some k ->
  value k = unary_real o (value i).
Proof.
intros F; destruct (find_sound _ _ _ _ F) as (m & t & A & B & C).
rewrite <- first_register in C.
destruct t as [|o' u|]; try discriminate; cbn in B.
apply Bool.andb_true_iff in B as (B & D).
destruct (operand _ _ _ m D C) as (L & E).
unfold value at 1; rewrite C, (register_result program inputs m _ A); [cbn; rewrite E|exact L].
destruct o, o'; try discriminate; reflexivity.
Qed.

Lemma binary_found o i j k : find_binary o i j program first = Some k ->
  value k = binary_real o (value i) (value j).
Proof.
intros F; destruct (find_sound _ _ _ _ F) as (m & t & A & B & C).
rewrite <- first_register in C.
destruct t as [| |o' u v]; try discriminate; cbn in B.
apply Bool.andb_true_iff in B as (B & D2); apply Bool.andb_true_iff in B as (B & D1).
destruct (operand _ _ _ m D1 C) as (L1 & E1), (operand _ _ _ m D2 C) as (L2 & E2).
unfold value at 1; rewrite C, (register_result program inputs m _ A);
  [cbn; rewrite E1, E2|split; assumption].
destruct o, o'; try discriminate; reflexivity.
Qed.

Lemma output_found i k : output i = Some k -> nth i (eval_real program inputs) 0 = value k.
Proof.
unfold output; set (m := (length program - 1 - i)%nat).
destruct (nth_error program m) as [[u| |]|] eqn:A; try discriminate.
destruct (Nat.ltb i (length program) && N.ltb (N.of_nat u) (first + N.of_nat m))%bool eqn:H;
  try discriminate; injection 1 as <-.
apply Bool.andb_true_iff in H as (H & L); apply Nat.ltb_lt in H; apply N.ltb_lt in L.
rewrite nth_register; rewrite stack_length; [|lia].
replace (length inputs + length program - 1 - i)%nat with (length inputs + m)%nat by lia.
rewrite (register_result program inputs m _ A); [|cbn; lia].
unfold value; cbn [result]; f_equal; lia.
Qed.

Lemma input_value k : (N.to_nat k < length inputs)%nat -> value k = register inputs (N.to_nat k).
Proof. intros; now apply register_kept. Qed.
End Values.

! Calls the checker from Fortran:
!   cc -std=c99 -O2 -c library.c
!   gfortran -O2 my_bicycle.f90 library.o -lm -o my_bicycle && ./my_bicycle
program my_bicycle
   use, intrinsic :: iso_c_binding
   implicit none
   interface
      function bicycle_evaluate(maneuver, column, t) bind(c)
         import :: c_int, c_double
         integer(c_int), value :: maneuver, column
         real(c_double), value :: t
         real(c_double) :: bicycle_evaluate
      end function bicycle_evaluate
      function bicycle_check_table(rows, table, row_stride, column_stride, first, maneuvers, digits, &
                                   text, size) bind(c)
         import :: c_int, c_double, c_size_t, c_ptrdiff_t, c_char
         integer(c_size_t), value :: rows, size
         integer(c_ptrdiff_t), value :: row_stride, column_stride
         integer(c_int), value :: first, maneuvers
         real(c_double), intent(in) :: table(*)
         real(c_double), intent(out) :: digits(*)
         character(kind=c_char), intent(out) :: text(*)
         integer(c_int) :: bicycle_check_table
      end function bicycle_check_table
   end interface
   integer, parameter :: rows = 1001
   integer(c_int), parameter :: right = 1
   real(c_double) :: table(rows, 25), digits(8, 3)
   character(kind=c_char) :: text(120)
   integer(c_int) :: i, m, c, grade
   ! YOUR CODE GOES HERE: the time, then eight columns of each maneuver. This stand-in is nearly exact.
   do i = 1, rows
      table(i, 1) = (i - 1)/100.0_c_double
      do m = 1, 3
         do c = 1, 8
            table(i, 1 + 8*(m - 1) + c) = bicycle_evaluate(m, c - 1, table(i, 1))*(1 + 1.0e-9_c_double)
         end do
      end do
   end do
   grade = bicycle_check_table(int(rows, c_size_t), table, 1_c_ptrdiff_t, int(rows, c_ptrdiff_t), 1, 3, &
                               digits, text, size(text, kind=c_size_t))
   i = 1
   do while (text(i) /= c_null_char)
      write (*, '(a)', advance='no') text(i)
      i = i + 1
   end do
   print '(/a, 8f6.1)', 'digits of maneuver 2:', digits(:, 2)
   if (grade /= right) error stop 'the bicycle is wrong'
end program my_bicycle

$about
module uncontrolled_bicycle
   use, intrinsic :: iso_fortran_env, only: real64
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   implicit none
   private
   public :: bicycle_evaluate

   ! Columns
$names

   integer, parameter :: columns = $columns, pieces = $pieces, terms = $terms
   ! Maneuvers, and the pieces of the i-th: first(i) to first(i + 1) - 1
   integer, parameter :: numbers(*) = [$numbers], first(*) = [$first]
   ! Piece p is from starts(p) to ends(p); a break belongs to the piece on its right.
   real(real64), save :: starts(pieces), ends(pieces)
   ! Chebyshev coefficients
   real(real64), save :: c(terms, pieces, columns)

$data
contains

   !> A column of a maneuver (1, 2, ...) at the time t [s], to the roundoff of real64. NaN for a
   !> time outside the run, and for a maneuver or column that is not in this file.
   elemental function bicycle_evaluate(maneuver, column, t) result(value)
      integer, intent(in) :: maneuver, column
      real(real64), intent(in) :: t
      real(real64) :: value, x, b1, b2, next
      integer :: i, k, low, high, middle

      value = ieee_value(value, ieee_quiet_nan)
      if (column < 1 .or. column > columns) return
      do i = 1, size(numbers)
         if (numbers(i) == maneuver) exit
      end do
      if (i > size(numbers)) return
      low = first(i)
      high = first(i + 1)
      if (.not. (t >= 0 .and. t <= ends(high - 1))) return
      do while (high - low > 1)
         middle = (low + high) / 2
         if (t >= starts(middle)) then
            low = middle
         else
            high = middle
         end if
      end do
      ! Clenshaw's rule for sum_k c_k T_k(x): b_k = c_k + 2 x b_(k+1) - b_(k+2)
      x = ((t - starts(low)) - (ends(low) - t)) / (ends(low) - starts(low))
      b1 = 0
      b2 = 0
      do k = terms, 2, -1
         next = c(k, low, column) + (2*x*b1 - b2)
         b2 = b1
         b1 = next
      end do
      value = c(1, low, column) + (x*b1 - b2)
   end function bicycle_evaluate

end module uncontrolled_bicycle

! Writes results.txt, 1001 rows of 25 columns, and scores it; ends with an error if it is wrong.
! Needs heyoka-bike on the PATH:
!   heyoka-bike export --format fortran
!   gfortran -O2 uncontrolled_bicycle.f90 my_bicycle.f90 -o my_bicycle && ./my_bicycle
program score_my_bicycle
   use, intrinsic :: iso_fortran_env, only: real64
   use uncontrolled_bicycle, only: bicycle_evaluate
   implicit none
   integer :: file, row, maneuver, code
   real(real64) :: t

   open (newunit=file, file='results.txt', status='replace', action='write')
   do row = 0, 1000
      t = row/100.0_real64
      write (file, '(25es25.16e3)') t, (my_bicycle(maneuver, t), maneuver=1, 3)
   end do
   close (file)
   call execute_command_line('heyoka-bike score results.txt --require "scd >= 6"', exitstat=code)
   if (code /= 0) error stop 'the bicycle is wrong'

contains

   !> YOUR CODE GOES HERE. Integrate the maneuver and give roll angle, roll rate, forward speed,
   !> potential, kinetic and mechanical energy, steer angle and steer rate at the time t. This
   !> stand-in looks them up in the reference.
   function my_bicycle(maneuver, t) result(columns)
      integer, intent(in) :: maneuver
      real(real64), intent(in) :: t
      real(real64) :: columns(8)
      integer :: i

      columns = bicycle_evaluate(maneuver, [(i, i=1, 8)], t)
   end function my_bicycle

end program score_my_bicycle

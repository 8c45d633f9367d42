/* The checker as a function of GNU Octave and MATLAB: [digits, line, grade] = check_bicycle(table)
     mkoctfile --mex check_bicycle.c     (MATLAB: mex check_bicycle.c)
   table has the time and eight columns of each maneuver; digits are 8 by the number of maneuvers. */
#include "uncontrolled_bicycle.h"
#include "mex.h"

void mexFunction(int count, mxArray *found[], int given, const mxArray *of[])
{
    char line[120];
    size_t rows;
    int maneuvers, grade;
    if (given != 1 || !mxIsDouble(of[0]) || mxIsComplex(of[0]))
        mexErrMsgTxt("expected a table of numbers");
    rows = mxGetM(of[0]);
    maneuvers = (int)(mxGetN(of[0]) - 1) / 8;
    if (mxGetN(of[0]) != (size_t)(1 + 8 * maneuvers) || maneuvers < 1)
        mexErrMsgTxt("expected a table of 9, 17 or 25 columns");
    found[0] = mxCreateDoubleMatrix(8, (mwSize)maneuvers, mxREAL);
    grade = bicycle_check_table(rows, mxGetPr(of[0]), 1, (ptrdiff_t)rows, 1, maneuvers,
                                mxGetPr(found[0]), line, sizeof line);
    if (count > 1)
        found[1] = mxCreateString(line);
    if (count > 2)
        found[2] = mxCreateDoubleScalar(grade);
}

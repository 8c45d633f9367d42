% Calls the checker from GNU Octave or MATLAB, in the folder of the header:
%   mkoctfile --mex check_bicycle.c && octave-cli my_bicycle.m     (MATLAB: mex check_bicycle.c)
right = 1;
% YOUR CODE GOES HERE: the time, then eight columns of each maneuver. This stand-in reads a table.
table = load('my-results.txt');
[digits, line, grade] = check_bicycle(table);
disp(line)
printf('digits of maneuver 2:%s\n', sprintf(' %.1f', digits(:, 2)))
if grade ~= right
    exit(1)
end

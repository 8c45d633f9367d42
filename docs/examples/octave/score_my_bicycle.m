% Writes results.txt, 1001 rows of 25 columns, and scores it; ends with an error if it is wrong.
% For GNU Octave and MATLAB, with heyoka-bike on the PATH:
%   heyoka-bike export --format matlab
%   octave-cli score_my_bicycle.m
t = (0:1000)' / 100;
results = t;
for maneuver = 1:3
    results = [results, my_bicycle(maneuver, t)];
end
file = fopen('results.txt', 'w');
fprintf(file, [repmat('%.17g ', 1, 24), '%.17g\n'], results');
fclose(file);
if system('heyoka-bike score results.txt --require "scd >= 6"') ~= 0
    error('the bicycle is wrong');
end

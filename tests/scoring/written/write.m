% The same rows as those of write.py, by GNU Octave.
x = load('rows.txt'); t = x(:, 1); y = x(:, 2:end); tout = t; yout = y;
keys = {'roll_angle', 'roll_rate', 'forward_speed', 'potential_energy', 'kinetic_energy', ...
        'mechanical_energy', 'steer_angle', 'steer_rate'};
s = struct();
for m = 1:3
  for k = 1:8
    q(m).(keys{k}) = x(:, 8 * m - 8 + k + 1);
    s.(sprintf('maneuver_%d', m)).(keys{k}) = x(:, 8 * m - 8 + k + 1);
  end
  q(m).time = t; s.(sprintf('maneuver_%d', m)).time = t;
end
simout = struct('time', t, 'signals', struct('values', y, 'dimensions', 24, 'label', ''));
save -v7 octave-7.mat t y
save -v6 octave-6.mat tout yout
save -v4 octave-4.mat x
save -v7 octave-structures.mat q
save -v7 octave-simout.mat simout
save('-hdf5', 'octave.h5', 't', 'y');
save('-hdf5', 'octave-structures.h5', 's');
save -text octave.txt x
dlmwrite('octave.csv', x, 'precision', '%.17g');
function put(name, value)
  f = fopen(name, 'w'); fprintf(f, '%s', jsonencode(value)); fclose(f);
end
put('octave-rows.json', x);
put('octave-structures.json', s);
put('octave-solution.json', struct('t', t, 'y', y));

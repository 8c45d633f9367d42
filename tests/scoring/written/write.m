% Write the same rows as write.py, with GNU Octave.
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
% Cell arrays with one cell per maneuver: of tables, and of columns next to their times.
for m = 1:3
  tables{m} = [t, y(:, 8 * m - 7:8 * m)]; times{m} = t; states{m} = tables{m}(:, 2:9);
end
save -v7 octave-cells.mat tables
save -v6 octave-cells-apart.mat times states
% Durations as MATLAB's writetimetable writes them, and a long table as its stack makes it.
f = fopen('timetable.csv', 'w'); fprintf(f, 'Time');
for m = 1:3, fprintf(f, ',m%d_%s', [repmat({m}, 1, 8); keys]{:}); end
fprintf(f, '\n');
for i = 1:rows(x), fprintf(f, '%.2f sec', t(i)); fprintf(f, ',%.17g', y(i, :)); fprintf(f, '\n'); end
fclose(f);
f = fopen('stacked.csv', 'w'); fprintf(f, 'maneuver,time,variable,value\n');
for m = 1:3
  for i = 1:rows(x)
    for k = 1:8
      fprintf(f, '%d,%.17g,%s,%.17g\n', m, t(i), keys{k}, y(i, 8 * m - 8 + k));
    end
  end
end
fclose(f);
f = fopen('labelled.txt', 'w');
for m = 1:3
  fprintf(f, 'Maneuver %d\n', m); fprintf(f, [repmat('%.17g ', 1, 9), '\n'], tables{m}');
end
fclose(f);

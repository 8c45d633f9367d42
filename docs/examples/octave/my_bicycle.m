function columns = my_bicycle(maneuver, t)
% YOUR CODE GOES HERE. Integrate the maneuver and give roll angle, roll rate, forward speed,
% potential, kinetic and mechanical energy, steer angle and steer rate at the times t, one column
% each. This stand-in looks them up in the reference.
names = {'roll_angle', 'roll_rate', 'forward_speed', 'potential_energy', ...
         'kinetic_energy', 'mechanical_energy', 'steer_angle', 'steer_rate'};
columns = zeros(numel(t), numel(names));
for i = 1:numel(names)
    columns(:, i) = uncontrolled_bicycle(maneuver, names{i}, t);
end
end

function values = $stem(maneuver, column, t)
% values = $stem(maneuver, column, t)
% A column of a maneuver (1, 2, ...) at the times t [s], an array of any shape, to the roundoff of
% double; NaN at times outside the run.
%
$about
persistent tables
if isempty(tables)
    tables = load_tables();
end
i = find([tables.number] == maneuver);
if isempty(i)
    error('$stem:maneuver', 'found maneuver %g, expected one of: %s', ...
          maneuver, sprintf('%d ', tables.number));
end
if ~isfield(tables(i).c, column)
    names = fieldnames(tables(i).c);
    error('$stem:column', 'found column ''%s'', expected one of: %s', ...
          column, sprintf('%s ', names{:}));
end
breaks = tables(i).breaks;
coefficients = tables(i).c.(column);
values = nan(size(t));
for p = 1:numel(breaks) - 1
    a = breaks(p);
    b = breaks(p + 1);
    % A break is in two pieces: the one on its right comes last.
    here = t >= a & t <= b;
    if any(here(:))
        % Clenshaw's rule for sum_k c_k T_k(x): b_k = c_k + 2 x b_(k+1) - b_(k+2)
        c = coefficients(p, :);
        x = ((t(here) - a) - (b - t(here))) / (b - a);
        b1 = zeros(size(x));
        b2 = b1;
        for k = numel(c):-1:2
            next = c(k) + (2 * x .* b1 - b2);
            b2 = b1;
            b1 = next;
        end
        values(here) = c(1) + (x .* b1 - b2);
    end
end
end

function tables = load_tables()
% Chebyshev coefficients: a row for each piece, from breaks(p) to breaks(p + 1)
$data
end

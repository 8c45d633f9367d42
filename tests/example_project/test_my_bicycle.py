from my_bicycle import run


def test_the_digits_are_as_good_as_ever(bicycle_reference, bicycle_score):
    bicycle_score(run(bicycle_reference.times)).require(scd=8)

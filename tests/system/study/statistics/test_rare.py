"""What both methods refuse before they begin."""

import pytest

from circuits.errors import ParameterError
from system.study.statistics.rare import check_budget


def test_nothing_varies() -> None:
    with pytest.raises(ParameterError, match="nothing varies"):
        check_budget(0, 5000, 100)


def test_too_few_samples() -> None:
    check_budget(3, 100, 100)
    with pytest.raises(ParameterError, match="samples: 99, must be >= 100"):
        check_budget(3, 99, 100)

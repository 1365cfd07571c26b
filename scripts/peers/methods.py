"""Each peer picks columns; all of them are used as their documentation does, with nothing tuned to the exam."""

import warnings

import numpy as np
import pysindy
from sklearn.linear_model import LassoLarsIC
from statsmodels.stats.diagnostic import acorr_ljungbox
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS

# In units of the noise: smaller effects do not matter, for any peer.
MATTERS = 0.3
MOST = 10


def stlsq(matrix, y):
    optimizer = pysindy.STLSQ(threshold=MATTERS, alpha=0.05)
    optimizer.fit(matrix, y.reshape(-1, 1))
    return np.ravel(optimizer.coef_)


def stepwise(matrix, y):
    """Forward selection by the Bayesian information criterion."""
    n = len(y)
    gram, moment, square = matrix.T @ matrix, matrix.T @ y, y @ y

    def solve(chosen):
        part = np.linalg.lstsq(gram[np.ix_(chosen, chosen)], moment[chosen], rcond=None)[0]
        left = max(square - part @ moment[chosen], 1e-12 * square)
        return n * np.log(left / n) + len(chosen) * np.log(n), part

    chosen, best, coefficients = [], n * np.log(square / n), np.zeros(0)
    while len(chosen) < MOST:
        others = [i for i in range(matrix.shape[1]) if i not in chosen]
        (criterion, part), i = min(((solve(chosen + [i]), i) for i in others), key=lambda s: s[0][0])
        if criterion >= best:
            break
        chosen, best, coefficients = chosen + [i], criterion, part
    full = np.zeros(matrix.shape[1])
    full[chosen] = coefficients
    return full


def lasso_lars(matrix, y):
    return LassoLarsIC(criterion="bic", max_iter=100).fit(matrix, y).coef_


def frols(matrix, y):
    """On every fourth sample: even so it takes seconds per channel."""
    matrix, y = matrix[::4], y[::4]
    columns = matrix.shape[1]
    model = FROLS(
        order_selection=True,
        n_info_values=MOST,
        info_criteria="bic",
        ylag=1,
        xlag=[[1]] * columns,
        model_type="NFIR",
        basis_function=Polynomial(degree=1),
    )
    # Its inputs act one sample later.
    model.fit(X=np.vstack([matrix[1:], matrix[-1:]]), y=y.reshape(-1, 1))
    full = np.zeros(columns)
    for code, theta in zip(model.final_model[:, 0], np.ravel(model.theta)):
        if code >= 2001:
            full[int(code) // 1000 - 2] = theta
    return full


PICK = {
    "PySINDy STLSQ": stlsq,
    "stepwise OLS, BIC": stepwise,
    "LassoLarsIC, BIC": lasso_lars,
    "sysidentpy FROLS, BIC": frols,
}


def white(y):
    """Ljung-Box on the residual."""
    return acorr_ljungbox(y, lags=[40])["lb_pvalue"].iloc[0] > 1e-4


def picked(pick, parts, matrix, size, y):
    """Sizes of the effects that a peer picked, in units of the noise."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        coefficients = np.asarray(pick(matrix, y))
    sums = {}
    for i in np.flatnonzero(coefficients):
        # Of the column as it is, in the channel's own unit.
        name, beyond = parts[i].named(coefficients[i] / size[i])
        if beyond != 0.0:
            sums[name] = sums.get(name, 0.0) + beyond * size[i] * matrix[:, i]
    return {name: float(np.sqrt(np.mean(total**2))) for name, total in sums.items()}


def as_picked(sizes):
    return sorted(sizes, key=sizes.get, reverse=True)


def largest(sizes):
    """The generous reading: at most two effects that matter, each more than half as large as the largest."""
    large = [n for n in as_picked(sizes) if sizes[n] > MATTERS]
    return [n for n in large if sizes[n] > 0.5 * sizes[large[0]]][:2]

"""Projections against closed forms and an independent implementation."""

import numpy as np
from sklearn.decomposition import PCA

from motorspace.analysis.projections import ica, pca

RNG = np.random.default_rng(0)


def test_pca_agrees_with_scikit_learn_up_to_sign():
    codes = RNG.normal(size=(300, 8)) @ RNG.normal(size=(8, 8))
    ours, theirs = pca(codes), PCA(3).fit(codes)
    np.testing.assert_allclose(np.abs(ours.coordinates), np.abs(theirs.transform(codes)), atol=1e-9)
    np.testing.assert_allclose(ours.explained_variance_ratio, theirs.explained_variance_ratio_)


def test_pca_of_collapsed_codes_explains_nothing():
    assert (pca(np.ones((10, 4))).explained_variance_ratio == 0).all()


def test_ica_finds_independent_sources():
    sources = RNG.uniform(-1, 1, size=(4000, 2))
    found = ica(sources @ np.array([[1.0, 0.4], [-0.7, 1.0]]), 2)
    match = np.abs(np.corrcoef(sources.T, found.T)[:2, 2:])
    assert match.max(axis=1).min() > 0.99

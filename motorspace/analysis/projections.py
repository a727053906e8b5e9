from typing import NamedTuple
import numpy as np
class P(NamedTuple):
    coordinates: object
def pca(codes, k=3):
    x=np.asarray(codes,np.float64); x=x-x.mean(0)
    u,s,v=np.linalg.svd(x,full_matrices=False)
    return P(x@v[:k].T)

"""Whether a peer works at its best. A goal against a peer that does not says nothing about slipd: the peer is left out, by name,
with what to do about it. Needs nothing beyond Python."""

FAST_BLAS = ("openblas", "mkl", "blis")
MOST_THREADS = 64  # more than this OpenBLAS may not have been built for


def refused(peer, why, remedy):
    """What a peer's program prints instead of its figures."""
    return {"part": "refused", "peer": peer, "why": why, "remedy": remedy}


def missing_refusal(peer, what, packages):
    return refused(peer, f"{what} is not installed", f"install {packages} (tools/setup --bench does)")


def blas_refusal(pools, cores):
    """Why scikit-learn is left out with these libraries, or None.

    pools: threadpoolctl.threadpool_info(), asked after numpy was imported. cores: that this process may use.
    """
    blas = [pool for pool in pools if pool.get("user_api") == "blas" and pool.get("internal_api") in FAST_BLAS]
    install = "install libopenblas0-pthread (tools/setup --bench does)"
    if not blas:
        return refused("scikit-learn", "numpy computes with the reference BLAS", install)
    threads = max(pool.get("num_threads", 1) for pool in blas)
    if threads >= min(cores, MOST_THREADS):
        return None
    if any(pool.get("threading_layer") == "disabled" for pool in blas):
        return refused("scikit-learn", "its OpenBLAS was built for one thread", install)
    return refused("scikit-learn", f"its BLAS uses {threads} of {cores} cores", "unset OPENBLAS_NUM_THREADS and OMP_NUM_THREADS")


def blas_text(pools):
    return ", ".join(sorted({f"{pool['internal_api']} {pool.get('version')}, {pool['num_threads']} threads"
                             for pool in pools if pool.get("user_api") == "blas"}))

"""Work that one MPI rank does for all of them."""

from collections.abc import Callable

from mpi4py import MPI

from fenics_defo.errors import DefoError


def on_first_rank[T](
    comm: MPI.Comm, work: Callable[[], T], *, for_others: Callable[[T], T] | None = None
) -> T:
    """Do something on rank 0 only and give its result, or its error, to all ranks.

    Collective. An error is raised on each rank, so that none waits for the others for ever.

    Args:
        comm: communicator.
        work: what rank 0 does.
        for_others: what of the result the other ranks need; all of it if not given.

    Returns:
        what ``work`` returned, on each rank.

    Raises:
        DefoError: the one that ``work`` raised; on the other ranks also in place of any other
            exception of rank 0.
    """
    if comm.size == 1:
        return work()
    if comm.rank == 0:
        try:
            result = work()
            shared = result if for_others is None else for_others(result)
        except DefoError as error:
            comm.bcast((None, error), root=0)
            raise
        except BaseException as error:
            comm.bcast((None, DefoError(f"rank 0 failed with {error!r}")), root=0)
            raise
        comm.bcast((shared, None), root=0)
        return result
    received, failure = comm.bcast(None, root=0)
    if failure is not None:
        raise failure
    return received

"""Work on several cores: threads of one process, since kernels run beside each other."""

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from typing import TypeVar

T = TypeVar("T")


class _Stopped(BaseException):
    """Ends a thread whose work nobody waits for."""


def in_threads(
    made: Callable[[int, Callable[[], None]], T],
    order: Iterable[int],
    show: Callable[[], None],
    workers: int,
) -> list[T]:
    """What is made of the numbers 0, 1, ..., begun in some order; the first error ends all.

    made : called in threads, with a number and what it must call now and then.
    show : called here, every tenth of a second.
    """
    stop = threading.Event()

    def look() -> None:
        if stop.is_set():
            raise _Stopped

    with ThreadPoolExecutor(workers, "beltrepro") as pool:
        futures = {int(number): pool.submit(made, int(number), look) for number in order}
        try:
            pending = set(futures.values())
            while pending:
                done, pending = wait(pending, 0.1, FIRST_EXCEPTION)
                for future in done:
                    future.result()
                show()
        except BaseException:  # Ctrl-C too
            stop.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [futures[number].result() for number in range(len(futures))]

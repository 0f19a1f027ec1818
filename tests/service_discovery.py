"""When a service can be called without its answer being lost."""

import time
from collections.abc import Callable
from typing import Any

_AGAIN = 1.0  # [s]


def await_answers(
    node: Any, spin_once: Callable[[], object], kind: Any, name: str, timeout: float = 20.0
) -> None:
    """Wait until a server knows where to send the answers of the clients that `node` has.

    A server that has been found need not have found the client yet, and its answer is then lost.
    Subscriptions are announced in order: once the service `name` of that server, which can be asked
    twice, answers a client that is made now, its node knows of all that were made before.
    """
    client = node.create_client(kind, name)
    end = time.monotonic() + timeout
    answers: list[Any] = []
    asked = 0.0
    while not any(answer.done() for answer in answers):
        found = client.service_is_ready()
        assert time.monotonic() < end, f"{name}: found {found}, asked {len(answers)} times in vain"
        if found and time.monotonic() > asked + _AGAIN:
            answers.append(client.call_async(kind.Request()))
            asked = time.monotonic()
        spin_once()
    node.destroy_client(client)

from __future__ import annotations

import os

import pytest

from rcss_hat.protocol import hear, messages, records, see, sense_body
from rcss_hat.protocol.commands import action
from rcss_hat.protocol.warm_up import warm_up

from .recorded import received


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="nothing is compiled")
def test_every_kernel_is_compiled_once_and_for_all() -> None:
    warm_up()
    kernels = (see._parse, sense_body._parse, hear._parse, action._write)
    assert [len(kernel.signatures) for kernel in kernels] == [1, 1, 1, 1]  # type: ignore[attr-defined]
    heard = records.empty(records.HEARD)
    for datagram in received()[:300]:
        for data in (datagram.text.encode(), datagram.text.encode() + b"\0"):
            messages.parse(data, datagram.team)
            hear.parse_hear_fast(data, heard)
    assert [len(kernel.signatures) for kernel in kernels] == [1, 1, 1, 1]  # type: ignore[attr-defined]

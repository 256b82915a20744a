"""What Fourier transforms along the angle need: where points and wavenumbers stand, and the factors.

See `taichiflap.fluids.navier_stokes.fourier`.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

POINTS, GROUPS, TAIL, SLOTS, PASSES, RADIX = range(6)
"""Entries of a plan: M, the groups of eight slots, whether there is one slot more, all slots, and the radices."""
PLAN = RADIX + 8

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Plan:
    """Plan of the transform of a row of `points`.

    Raises:
        ValueError: when `points` is no multiple of 16 whose eighth has the prime factors 2 and 3 alone.
    """

    points: int

    def __post_init__(self) -> None:
        rest = self.points // 8
        for factor in (2, 3):
            while rest and rest % factor == 0:
                rest //= factor
        if self.points % 16 or rest != 1:
            raise ValueError(f"{self.points} points: no multiple of 16 whose eighth is a product of twos and threes")

    @property
    def octets(self) -> int:
        """Octets of a row."""
        return self.points // 8

    @property
    def tail(self) -> bool:
        """Whether k1 = M/2 has its own slot."""
        return self.octets // 2 % 8 == 0

    @property
    def groups(self) -> int:
        """Groups of eight slots."""
        return self.octets // 16 if self.tail else self.octets // 16 + 1

    @property
    def slots(self) -> int:
        """Slots of a spectrum, each a real and an imaginary octet."""
        return 8 * self.groups + self.tail

    @property
    def radices(self) -> list[int]:
        """Radices of the passes; 8 only in the last, which needs no twiddles."""
        rest, last, found = self.octets, [], []
        if rest % 8 == 0 and rest not in (16, 64):
            rest, last = rest // 8, [8]
        for radix in (4, 3, 2):
            while rest % radix == 0:
                rest //= radix
                found.append(radix)
        return found + last

    @cached_property
    def index(self) -> NDArray[np.int64]:
        """Wavenumber, 0 .. N - 1, of every slot and lane."""
        lane = np.arange(8)
        slots = [8 * g + lane + self.octets * k2 for g in range(self.groups) for k2 in range(8)]
        if self.tail:
            slots.append(self.octets // 2 + self.octets * lane)
        return np.array(slots) % self.points

    @property
    def wavenumber(self) -> NDArray[np.int64]:
        """The same, signed: -N/2 .. N/2 - 1."""
        return np.where(self.index >= self.points // 2, self.index - self.points, self.index)

    @property
    def entries(self) -> list[int]:
        """The plan as kernels read it."""
        head = [self.octets, self.groups, int(self.tail), self.slots, len(self.radices), *self.radices]
        return head + [0] * (PLAN - len(head))

    @property
    def roots(self) -> NDArray[np.float64]:
        """Powers of the M-th root of unity, shape (M, 2)."""
        powers = np.exp(-2j * np.pi * np.arange(self.octets) / self.octets)
        return np.stack((powers.real, powers.imag), axis=1)

    @property
    def twiddles(self) -> NDArray[np.float64]:
        """Twiddles of k1 and lane, shape (k1, 2, 8)."""
        count = 8 * self.groups + self.tail
        powers = np.exp(-2j * np.pi * np.arange(count)[:, None] * np.arange(8) / self.points)
        return np.stack((powers.real, powers.imag), axis=1)

    def spectrum(self, slots: NDArray[np.float64]) -> Complex:
        """A row's slots, shape (2 slots, 8), as `numpy.fft.fft` orders them."""
        found = np.zeros(self.points, complex)
        values = slots[0 : 2 * self.slots : 2] + 1j * slots[1 : 2 * self.slots : 2]
        found[-self.index % self.points] = values.conj()
        found[self.index] = values
        return found

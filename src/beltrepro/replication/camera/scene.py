"""What lies under the camera: blocks, springs, support and tape measure, in SI (Sec. II)."""

from dataclasses import dataclass, fields

from beltrepro.base.checks import finite_number, positive
from beltrepro.base.errors import InputError


@dataclass(frozen=True)
class Scene:
    """Sizes of the things on the belt, in metres, and how bright they are.

    Brightness goes from 0 (black) to 255 (white). The support is at x = 0, and the chain extends to
    the right. The tape measure lies beside the chain and has its zero at the support.
    """

    block_length: float = 0.04  # of a block, along the belt and across it (Sec. II: 4 cm and 8 cm)
    block_width: float = 0.08
    spring_width: float = 0.012  # diameter of the springs
    coils: int = 8  # turns of a spring
    tape_gap: float = 0.015  # distance of the tape measure from the blocks, and its width
    tape_width: float = 0.02
    mark_spacing: float = 0.01  # distance of the marks of the tape measure; every tenth is longer
    mark_width: float = 0.002  # of a mark, along the belt, and across it
    mark_length: float = 0.008
    long_mark_length: float = 0.014
    # brightness of the belt, the tops of the blocks, that of the last one, and so on
    belt: float = 28.0
    block: float = 10.0
    white_block: float = 235.0
    spring: float = 90.0
    support: float = 70.0
    tape: float = 190.0
    mark: float = 20.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name not in _BRIGHTNESS:
                positive(field.name, value)
            elif not 0 <= finite_number(field.name, value) <= 255:
                raise InputError(f"{field.name} = {value:g}: a brightness is from 0 to 255")

    @property
    def width(self) -> float:
        """Of all there is, across the belt, from the edge of the blocks to that of the tape."""
        return self.block_width + self.tape_gap + self.tape_width


_BRIGHTNESS = ("belt", "block", "white_block", "spring", "support", "tape", "mark")

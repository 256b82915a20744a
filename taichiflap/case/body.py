"""`[body]`: what the wings carry."""

from pydantic.json_schema import SkipJsonSchema

from .schema import CaseTable, key


class Body(CaseTable):
    """The body that the wings carry: its weight is what the lift is compared with."""

    mass: float | SkipJsonSchema[None] = key(
        None, unit="kg", text="mass of the animal or craft", example=1.6e-3, gt=0, le=1e6
    )
    wings: int = key(2, text="number of such wings that carry it", ge=1, le=100)

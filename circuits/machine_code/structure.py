"""Named tuples as kernels take them: the address of a table of their fields.

numba hands a tuple over field by field, an array being seven numbers. Of a circuit those are some hundred
arrays, in each call of each kernel, which takes longer to compile than what the kernel does. So a named tuple
that Python gives to a kernel is written into memory once, at the call, and kernels hand on its address.
Nothing is written there again: what is loaded from it can stay in a register (LLVM's `invariant.load`).

A named tuple that a kernel makes itself stays a tuple of numba's, as do those of packages without kernels,
which may use numba in their own way.
"""

from __future__ import annotations

import hashlib
from typing import Any, final

from llvmlite import ir  # type: ignore[import-untyped]
from numba.core import cgutils, types
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.core.typing.typeof import Purpose, typeof_impl
from numba.core.typing.typeof import _typeof_tuple as _numbas
from numba.extending import NativeValue, lower_getattr_generic, models, register_model, unbox

from circuits.machine_code.packages import of_package_with_kernels

_ADDRESS = ir.IntType(8).as_pointer()
_ZERO = ir.IntType(32)(0)


@final
class Structure(types.Type):
    """A named tuple in memory: its class, and the types of its fields."""

    def __init__(self, made: Any, kinds: tuple[Any, ...]) -> None:
        self.made, self.types = made, kinds
        text = ",".join(map(str, kinds))
        # the whole text, some thousand letters, would be in the name of each function that takes one
        super().__init__(name=f"{made.__name__}_{hashlib.sha256(text.encode()).hexdigest()[:16]}")

    @property
    def key(self) -> Any:
        """What tells two of them apart."""
        return self.made, self.types


@register_model(Structure)
class _Model(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, _ADDRESS)


@infer_getattr
class _Fields(AttributeTemplate):
    key = Structure

    def generic_resolve(self, kind: Any, name: str) -> Any:  # type: ignore[override]
        """The type of a field."""
        fields: tuple[str, ...] = kind.made._fields
        return kind.types[fields.index(name)] if name in fields else None


@lower_getattr_generic(Structure)
def _field(context: Any, builder: Any, kind: Structure, address: Any, name: str) -> Any:
    """A field; of a structure in a structure, where it begins."""
    index = kind.made._fields.index(name)
    table = builder.bitcast(address, _table(context, kind).as_pointer())
    place, field = _at(builder, table, index), kind.types[index]
    if isinstance(field, Structure):
        return builder.bitcast(place, _ADDRESS)
    return context.data_model_manager[field].from_data(builder, _loaded(builder, place))


def _table(context: Any, kind: Any) -> Any:
    """How fields stand in memory."""
    if isinstance(kind, Structure):
        return ir.LiteralStructType([_table(context, field) for field in kind.types])
    return context.get_data_type(kind)


def _at(builder: Any, place: Any, index: int) -> Any:
    return builder.gep(place, [_ZERO, ir.IntType(32)(index)], inbounds=True)


def _loaded(builder: Any, place: Any) -> Any:
    """What stands at a place, by a function of its own where that is many numbers: it is written once."""
    kind = place.type.pointee
    if not isinstance(kind, ir.Aggregate):
        found = builder.load(place)
        found.set_metadata("invariant.load", builder.module.add_metadata([]))
        return found
    name = f"noctule.load.{kind}"
    function = builder.module.globals.get(name) or _loader(builder.module, kind, name)
    return builder.call(function, [place])


def _loader(module: Any, kind: Any, name: str) -> Any:
    """A function that loads number by number: LLVM drops what is said of the load of a whole array."""
    function = ir.Function(module, ir.FunctionType(kind, [kind.as_pointer()]), name)
    function.linkage = "linkonce_odr"
    function.attributes.add("alwaysinline")
    builder = ir.IRBuilder(function.append_basic_block())
    whole = ir.Constant(kind, ir.Undefined)
    for index in range(len(kind)):
        whole = builder.insert_value(whole, _loaded(builder, _at(builder, function.args[0], index)), index)
    builder.ret(whole)
    return function


@unbox(Structure)
def _unboxed(kind: Structure, given: Any, c: Any) -> Any:
    """Write the fields of Python's tuple to the stack of who calls; arrays are borrowed for the call."""
    place = cgutils.alloca_once(c.builder, _table(c.context, kind))
    failed = cgutils.alloca_once_value(c.builder, cgutils.false_bit)
    _fill(kind, given, place, failed, c)
    return NativeValue(c.builder.bitcast(place, _ADDRESS), is_error=c.builder.load(failed))


def _fill(kind: Any, given: Any, place: Any, failed: Any, c: Any) -> None:
    """Write the fields to a place: a structure in another as part of it, in a plain tuple its address."""
    inside = types.BaseTuple | Structure if isinstance(kind, Structure) else types.BaseTuple
    for index, field in enumerate(kind.types):
        value, at = c.pyapi.tuple_getitem(given, index), _at(c.builder, place, index)
        if isinstance(field, inside):
            _fill(field, value, at, failed, c)
            continue
        if isinstance(field, types.Array):
            wrong = _adapted(value, at, c)
        else:
            native = c.unbox(field, value)
            c.builder.store(c.context.data_model_manager[field].as_data(c.builder, native.value), at)
            wrong = native.is_error
        c.builder.store(c.builder.or_(c.builder.load(failed), wrong), failed)


def _adapted(given: Any, place: Any, c: Any) -> Any:
    """Write what numba knows of an array to a place, which then does not own it; whether that failed."""
    kind = ir.FunctionType(ir.IntType(32), [c.pyapi.pyobj, _ADDRESS])
    adapt = cgutils.get_or_insert_function(c.builder.module, kind, "numba_adapt_ndarray")
    return cgutils.is_not_null(c.builder, c.builder.call(adapt, [given, c.builder.bitcast(place, _ADDRESS)]))


@typeof_impl.register(tuple)
def _type_of(value: Any, context: Any) -> Any:
    """Type of a tuple that is given to a kernel."""
    kind = type(value)
    if context.purpose is Purpose.argument and hasattr(kind, "_fields") and of_package_with_kernels(kind):
        fields = tuple(typeof_impl(each, context) for each in value)
        if all(map(_has_place, fields)):
            return Structure(kind, fields)
    return _numbas(value, context)


def _has_place(kind: Any) -> bool:
    """Whether a field of the type can stand in a table."""
    plain: Any = types.BaseAnonymousTuple
    if isinstance(kind, plain):
        return all(map(_has_place, kind.types))
    return isinstance(kind, types.Array | types.Number | types.Boolean | types.NoneType | Structure)

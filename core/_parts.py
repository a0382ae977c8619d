"""How kernels are compiled that kernels call: once, as a part of each that Python calls.

numba compiles every function for callers in machine code, for Python and for C, optimises each
together with all that it calls, and makes machine code of each. For what kernels alone call that is
in vain. Here such a kernel stays LLVM's own code until the kernel that Python has called is put
together from its parts, and optimised once (docs/decisions/0021-first-compilation.md).

A kernel that is found in the disk cache needs no parts: they are not kept there.
"""

from __future__ import annotations

from contextlib import nullcontext
from typing import ClassVar

import llvmlite.binding as llvm
from llvmlite import ir
from numba.core import cgutils, compiler, lowering, typed_passes, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import register_pass
from numba.core.registry import CPUDispatcher

from ._kernel_files import KernelFiles, is_kept
from ._quicker import quicker

# Releases whose inner classes are those that this file extends; for others _jit.py does without.
KNOWN_NUMBA = {(0, 68)}


def new_kernel(function, options: dict) -> Kernel:
    """As numba's njit(cache=True, **options)(function); it cannot call itself."""
    defaults = {"nopython": True, "boundscheck": None, "no_cfunc_wrapper": True}
    kernel = Kernel(function, {}, defaults | options, pipeline_class=_WholeCompiler)
    kernel.enable_caching()
    KernelFiles.take_over(kernel._cache)
    return kernel


class Kernel(CPUDispatcher):
    """A dispatcher for Python; kernels that call it get its part instead."""

    _part = None

    def compile(self, sig):
        """Load or compile what Python has called: of several processes one compiles."""
        with global_compiler_lock, self._turn(sig), quicker():
            return super().compile(sig)

    def _turn(self, sig):
        files = getattr(
            self._cache, "_cache_file", None
        )  # of a kernel that is not kept there is none
        if files is None or (isinstance(sig, tuple) and self.is_kept(sig)):
            return nullcontext()
        return files.turn()

    def is_kept(self, args: tuple) -> bool:
        """Whether there is machine code for arguments of these types, here or in the cache."""
        if args in self.overloads:
            return True
        return is_kept(self._cache, args, self.targetctx.codegen())

    def get_call_template(self, args, kws):
        """What type inference asks of a callee; one part serves all integers that are written."""
        args = tuple(types.unliteral(kind) for kind in args)
        kws = {name: types.unliteral(kind) for name, kind in kws.items()}
        return self._as_part().get_call_template(args, kws)

    def get_overload(self, sig):
        """What lowering asks of a callee."""
        return self._as_part().get_overload(sig)

    def _as_part(self) -> _Part:
        if self._part is None:
            options = self.targetoptions | {"no_cpython_wrapper": True}
            self._part = _Part(self.py_func, {}, options, pipeline_class=_PartCompiler)
        return self._part


class _Part(CPUDispatcher):
    """The same function for kernels only: Python cannot call it, and finds no machine code."""

    def add_overload(self, cres):
        self.overloads[tuple(cres.signature.args)] = cres


class _WholeLibrary(JITCodeLibrary):
    """numba's, but the passes over single functions are made ready once and not for each.

    What numba has written is checked once, when it is all put together.
    """

    def add_ir_module(self, ir_module):
        self._raise_if_finalized()
        module = llvm.parse_assembly(cgutils.normalize_ir_text(str(ir_module)))
        module.name = ir_module.name
        self.add_llvm_module(module)

    def _optimize_functions(self, ll_module):
        ll_module.data_layout = self._codegen._data_layout
        manager, builder = self._codegen._function_pass_manager()
        for function in ll_module.functions:
            if not function.is_declaration:
                manager.run(function, builder)


class _PartLibrary(_WholeLibrary):
    """Code that is linked into other code: not optimised as a whole, not made machine code."""

    def _optimize_final_module(self):
        pass

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


def _unsigned(kind):
    return types.uintp if isinstance(kind, types.Integer) and kind.signed else kind


def _counted_from_the_start(signature):
    """The signature of an access to an array, with indices that have no sign."""
    array, index, *value = signature.args
    if not isinstance(array, types.Array):
        return signature
    if isinstance(index, types.BaseTuple):
        index = types.BaseTuple.from_types([_unsigned(kind) for kind in index])
    return signature.replace(args=(array, _unsigned(index), *value))


class _Lower(lowering.Lower):
    """numba's, without what it does to variables to count references, where none are counted.

    A NamedTuple may hold hundreds of numbers, and LLVM takes it apart into them wherever it is
    read as a whole, written, or forgotten.

    An index of a kernel counts from the start of an array, never from its end: numba asks of each
    one whether it is negative, which costs more than the access, and keeps loops out of vectors.
    """

    def storevar(self, value, name, argidx=None):
        if self._counts() or name in self._singly_assigned_vars or argidx is not None:
            super().storevar(value, name, argidx)
        else:
            self._alloca_var(name, self.typeof(name))
            self.builder.store(value, self.getvar(name))

    def delvar(self, name):
        if self._counts():
            super().delvar(name)
        elif name not in self._blk_local_varmap:
            self._singly_assigned_vars.discard(name)

    def alloca_lltype(self, name, lltype, datamodel=None):
        if self._counts() or not isinstance(lltype, ir.Aggregate):
            return super().alloca_lltype(name, lltype, datamodel)
        with self.builder.goto_entry_block():
            return self.builder.alloca(lltype, name=name)

    def lower_expr(self, resty, expr):
        if expr.op == "getattr" and not self._counts():
            kind, name = self.typeof(expr.value.name), expr.value.name
            if isinstance(kind, types.BaseNamedTuple) and name not in self._blk_local_varmap:
                field = kind.fields.index(expr.attr)
                place = cgutils.gep_inbounds(self.builder, self.getvar(name), 0, field)
                value = self.builder.load(place)
                return self.context.cast(self.builder, value, kind.types[field], resty)
        return super().lower_expr(resty, expr)

    def lower_getitem(self, resty, expr, value, index, signature):
        own = _counted_from_the_start(signature)
        return super().lower_getitem(resty, expr, value, index, own)

    def lower_setitem(self, target_var, index_var, value_var, signature):
        own = _counted_from_the_start(signature)
        return super().lower_setitem(target_var, index_var, value_var, own)

    def _counts(self) -> bool:
        return self.context.enable_nrt or self._disable_sroa_like_opt


class _KernelLowering(typed_passes.NativeLowering):
    @property
    def lowering_class(self):
        return _Lower


@register_pass(mutates_CFG=True, analysis_only=False)
class _WholeLowering(_KernelLowering):
    _name = "iwis_whole_lowering"

    def run_pass(self, state):
        name = state.func_id.func_qualname
        state.library = _WholeLibrary(state.targetctx.codegen(), name)
        state.library.enable_object_caching()
        return super().run_pass(state)


class _Key:
    """What a part is known by among all functions that may be called."""


@register_pass(mutates_CFG=True, analysis_only=False)
class _PartLowering(_KernelLowering):
    _name = "iwis_part_lowering"

    def run_pass(self, state):
        name = state.func_id.func_qualname
        state.library = _PartLibrary(state.targetctx.codegen(), name)
        state.flags.no_compile = True
        super().run_pass(state)
        lowered, key = state["cr"], _Key()
        state.library.finalize()
        state.targetctx.insert_user_function(key, lowered.fndesc, [state.library])
        state["cr"] = lowered._replace(cfunc=key)
        return True


class _Settled(compiler.Flags):
    """Options while a kernel is compiled, one object for equal ones: numba looks up by them."""

    _known: ClassVar[dict[str, _Settled]] = {}
    __hash__ = object.__hash__

    def __eq__(self, other):
        return self is other

    def copy(self):
        return compiler.Flags(self)


class _Flags(compiler.Flags):
    """Options of a kernel; numba takes a copy of them for the time that it compiles."""

    def copy(self):
        settled = _Settled(self)
        for name in ("no_cpython_wrapper", "no_cfunc_wrapper", "no_compile", "release_gil"):
            settled.discard(name)
        return _Settled._known.setdefault(repr(settled), settled)


class _WholeCompiler(compiler.CompilerBase):
    _lowering = _WholeLowering

    def _compile_core(self):
        self.state.flags = _Flags(self.state.flags)
        return super()._compile_core()

    def define_pipelines(self):
        manager = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.passes = [
            (self._lowering if kind is typed_passes.NativeLowering else kind, why)
            for kind, why in manager.passes
        ]
        manager.finalize()
        return [manager]


class _PartCompiler(_WholeCompiler):
    _lowering = _PartLowering

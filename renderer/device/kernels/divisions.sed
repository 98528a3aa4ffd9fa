# Divisions whose numerator or divisor may be zero, for sed -E.
#
# What NVIDIA's assembler makes of div.rn.f32 calls a function of some forty instructions where an
# operand is zero, and a warp does that if one of its threads does. Of the divisions of a render 9 %
# have a numerator of zero (a color without red, say) and 4 % a divisor. So threads with a zero
# divide other numbers, and multiply to get theirs:
#   a / b = a * (2^-40 / b)             where a is zero; 2^-40 / b is finite for all b but 0 and NaN
#   a / b = a * infinity of b's sign    where b is zero; both: NaN
# SPDX-License-Identifier: Apache-2.0
s/^\tdiv\.rn\.f32 \t(%f[0-9]+), ([^,]+), ([^;]+);/\t{\n\t.reg .pred no_numerator;\n\t.reg .pred no_divisor;\n\t.reg .pred special;\n\t.reg .b32 bits;\n\t.reg .f32 numerator;\n\t.reg .f32 divisor;\n\t.reg .f32 quotient;\n\t.reg .f32 factor;\n\tsetp.eq.f32 \tno_numerator, \2, 0f00000000;\n\tsetp.eq.f32 \tno_divisor, \3, 0f00000000;\n\tor.pred \tspecial, no_numerator, no_divisor;\n\tselp.f32 \tnumerator, 0f2B800000, \2, special;\n\tselp.f32 \tdivisor, 0f3F800000, \3, no_divisor;\n\tdiv.rn.f32 \tquotient, numerator, divisor;\n\tmov.b32 \tbits, \3;\n\tor.b32 \tbits, bits, 2139095040;\n\tmov.b32 \tfactor, bits;\n\tselp.f32 \tfactor, factor, quotient, no_divisor;\n\tmul.rn.f32 \tfactor, \2, factor;\n\tselp.f32 \t\1, factor, quotient, special;\n\t}/

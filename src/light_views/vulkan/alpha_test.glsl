// SPDX-License-Identifier: Apache-2.0
// Alpha of a material at uv, bilinear from its finest level, like scene::Texture::alpha. Needs the buffers
// `alpha_materials` and `alpha_texels`.

int alpha_wrapped(int i, int n, uint mode)
{
    if (mode == 2u) return clamp(i, 0, n - 1);
    int period = mode == 1u ? 2 * n : n;
    int k = i % period;
    if (k < 0) k += period;
    return k < n ? k : period - 1 - k;
}

float alpha_texel(AlphaMaterial m, int x, int y)
{
    uint i = m.first_byte + uint(alpha_wrapped(y, int(m.height), m.wrap_v)) * m.width + uint(alpha_wrapped(x, int(m.width), m.wrap_u));
    return float((alpha_texels[i / 4u] >> (8u * (i % 4u))) & 255u) / 255.0;
}

bool passes_alpha_test(AlphaMaterial m, vec2 texcoord)
{
    float alpha = m.alpha;
    if (m.first_byte != 0xffffffffu) {
        vec2 at = m.offset + vec2(dot(m.row_u, texcoord), dot(m.row_v, texcoord));
        at = at * vec2(m.width, m.height);
        if (m.nearest != 0u) return alpha * alpha_texel(m, int(floor(at.x)), int(floor(at.y))) >= m.cutoff;
        at -= 0.5;
        vec2 low = floor(at), part = at - low;
        int x = int(low.x), y = int(low.y);
        float top = mix(alpha_texel(m, x, y), alpha_texel(m, x + 1, y), part.x);
        float bottom = mix(alpha_texel(m, x, y + 1), alpha_texel(m, x + 1, y + 1), part.x);
        alpha *= mix(top, bottom, part.y);
    }
    return alpha >= m.cutoff;
}

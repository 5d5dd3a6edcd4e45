// Push without the rasteriser: an invocation finishes two columns of a block, two rows at a time.
//
//     columns 2 x - 1 and 2 x, rows 2 y - 1 and 2 y: all four pixels read the same four coarse pixels.
//
// Two of the four coarse pixels stay from the rows before, so each pixel costs half a coarse fetch
// instead of four. The eight lanes of a software driver work on the columns of one block. Needs
// push.glsl and blocks.glsl. The including file defines
//     struct stp_made, and stp_made stp_make(stp_pixel p, ivec2 here)
//     void stp_put(ivec2 here, stp_made made, stp_made right, stp_made above, stp_made beyond, bvec4 wanted)
// stp_make packs one pixel at a time, so that less is kept until stp_put stores all four. wanted:
// which of the four to store. Pixels that push missed come one by one, in a loop that software drivers
// skip if no lane has any.

#if STP_COLUMNS_IN_PLACE
#define STP_WANTED(pushed) pushed
#else
#define STP_WANTED(pushed) bvec4(true)
#endif

void main()
{
    uvec2 block = stp_block();
    ivec2 in_block = ivec2(2 * gl_LocalInvocationID.x, 0);
    ivec2 here = stp_block_place(block) + in_block;
    ivec2 coarse = here >> 1;
    stp_pixel a0 = stp_push_look(coarse);
    stp_pixel a1 = stp_push_look(coarse + ivec2(1, 0));
    for (int row = 0; row < STP_BLOCK_SIZE.y / 2; row++) {
        stp_pixel b0 = stp_push_look(coarse + ivec2(0, 1));
        stp_pixel b1 = stp_push_look(coarse + ivec2(1, 1));
        bvec4 pushed, missed;
        stp_made made = stp_make(stp_push_from(here, a0, a1, b0, b1, pushed.x, missed.x), here);
        stp_made right = stp_make(stp_push_from(here + ivec2(1, 0), a1, a0, b1, b0, pushed.y, missed.y), here + ivec2(1, 0));
        stp_made above = stp_make(stp_push_from(here + ivec2(0, 1), b0, b1, a0, a1, pushed.z, missed.z), here + ivec2(0, 1));
        stp_made beyond = stp_make(stp_push_from(here + ivec2(1, 1), b1, b0, a1, a0, pushed.w, missed.w), here + ivec2(1, 1));
        bvec4 asked = bvec4(stp_block_wants(block, in_block), stp_block_wants(block, in_block + ivec2(1, 0)),
                            stp_block_wants(block, in_block + ivec2(0, 1)), stp_block_wants(block, in_block + 1));
#if STP_COLUMNS_IN_PLACE
        uvec4 bits = (uvec4(missed) & uvec4(asked)) << uvec4(0u, 1u, 2u, 3u);
        for (uint left = bits.x | bits.y | bits.z | bits.w; left != 0u; left &= left - 1u) {
            int k = findLSB(left);
            ivec2 at = here + ivec2(k & 1, k >> 1);
            stp_pixel p = stp_push_further(at, stp_pixel_invalid());
            stp_put_one(at, stp_make(p, at), p.tag != 0);
            pushed[k] = pushed[k] && p.tag == 0;
        }
#endif
        stp_put(here, made, right, above, beyond, bvec4(uvec4(asked) & uvec4(STP_WANTED(pushed))));
        a0 = b0;
        a1 = b1;
        in_block.y += 2;
        here.y += 2;
        coarse.y++;
    }
}

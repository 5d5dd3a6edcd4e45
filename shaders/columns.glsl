// Push without the rasteriser: an invocation finishes two columns of a block of pixels, two rows at a time. The four
// pixels of one parent read the same three by three around it, of which six were there for the two rows above: for a
// pixel three quarters of a coarse one are fetched instead of four, and what is unpacked serves five. The eight lanes of
// a software driver are a block's columns. Needs push.glsl and blocks.glsl; who includes it defines
//     void stp_put(ivec2 here, stp_pixel p, stp_pixel right, stp_pixel below, stp_pixel beyond, bvec4 wanted)
// which gets a parent's four pixels and which of them are to be written.

#if STP_COLUMNS_IN_PLACE
#define STP_WANTED(pushed) pushed
#else
#define STP_WANTED(pushed) bvec4(true)
#endif

void main()
{
    uint block = stp_block();
    ivec2 parent = (stp_block_place(block) >> 1) + ivec2(gl_LocalInvocationID.x, 0);
    stp_pixel a0 = stp_push_look(parent + ivec2(-1, -1));
    stp_pixel a1 = stp_push_look(parent + ivec2(0, -1));
    stp_pixel a2 = stp_push_look(parent + ivec2(1, -1));
    stp_pixel b0 = stp_push_look(parent + ivec2(-1, 0));
    stp_pixel b1 = stp_push_look(parent);
    stp_pixel b2 = stp_push_look(parent + ivec2(1, 0));
    for (int row = 0; row < STP_BLOCK_SIZE.y / 2; row++) {
        stp_pixel c0 = stp_push_look(parent + ivec2(-1, 1));
        stp_pixel c1 = stp_push_look(parent + ivec2(0, 1));
        stp_pixel c2 = stp_push_look(parent + ivec2(1, 1));
        ivec2 here = 2 * parent;
        bvec4 pushed;
        stp_pixel p = stp_push_from(here, b1, b0, a1, a0, pushed.x);
        stp_pixel right = stp_push_from(here + ivec2(1, 0), b1, b2, a1, a2, pushed.y);
        stp_pixel below = stp_push_from(here + ivec2(0, 1), b1, b0, c1, c0, pushed.z);
        stp_pixel beyond = stp_push_from(here + ivec2(1, 1), b1, b2, c1, c2, pushed.w);
        bool asked = stp_block_wants(block, 2 * ivec2(gl_LocalInvocationID.x, row));
        bvec2 more = lessThan(here + 1, level_size);
        bvec4 there = bvec4(asked, asked && more.x, asked && more.y, asked && more.x && more.y);
        stp_put(here, p, right, below, beyond, bvec4(uvec4(there) & uvec4(STP_WANTED(pushed))));
        a0 = b0;
        a1 = b1;
        a2 = b2;
        b0 = c0;
        b1 = c1;
        b2 = c2;
        parent.y++;
    }
}

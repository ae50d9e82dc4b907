// Smith and van der Walt 2015, magma (CC0), each tenth of it: perceptually uniform in CAM02-UCS,
// with lightness rising throughout. RGB(r, g, b) makes an entry of three bytes, encoded as sRGB.
#ifdef __cplusplus
#pragma once
#endif

#define MAGMA_COUNT 11
#define MAGMA(RGB)                                                                                 \
    RGB(0x00, 0x00, 0x04), RGB(0x14, 0x0e, 0x36), RGB(0x3b, 0x0f, 0x70), RGB(0x64, 0x1a, 0x80),    \
        RGB(0x8c, 0x29, 0x81), RGB(0xb7, 0x37, 0x79), RGB(0xde, 0x49, 0x68),                       \
        RGB(0xf7, 0x70, 0x5c), RGB(0xfe, 0x9f, 0x6d), RGB(0xfe, 0xcf, 0x92), RGB(0xfc, 0xfd, 0xbf)

// Numbers of many limbs agree with those of python-flint, computed with 2000 bits and cut off.
#include "numbers/fixed.hpp"

#include "facts.hpp"

using namespace urdf_ik::URDF_IK_LEVEL;

namespace {

using W = Wide<6>;
struct Case {
    double a, b, c;
    int what;
    struct {
        std::uint64_t m[6];
        int exponent;
        bool negative;
    } result;
};
// clang-format off
const Case CASES[] = {
    {-0x1.7d4fc88363addp+45, -0x1.484020911b56dp+59, 0x1.e56e4a50179a4p-2, 0, {{0x0, 0x0, 0x0, 0x4a02f34800000000, 0x9d0231288cbcadc9, 0xf476deae4a44aacc}, 105, false}},
    {-0x1.7d4fc88363addp+45, -0x1.484020911b56dp+59, 0x1.e56e4a50179a4p-2, 1, {{0xd38fc834fbbdc3b9, 0x630092ead582f630, 0x23f661ee357d3b22, 0x8f0b21f88f99a4ec, 0x5984c9c64df54704, 0x94b0e4c653f88e91}, -13, false}},
    {-0x1.7d4fc88363addp+45, -0x1.484020911b56dp+59, 0x1.e56e4a50179a4p-2, 2, {{0xe6b3b498add11603, 0x3a79be93c03f36fa, 0xbc49307f049b2283, 0x3d9febaed7a3f49a, 0x377fc96b290363b0, 0xb0428c90e7462f27}, 0, false}},
    {-0x1.7d4fc88363addp+45, -0x1.484020911b56dp+59, 0x1.e56e4a50179a4p-2, 3, {{0xc50c53c1518cc2b0, 0x97a635b62eccec9a, 0xb66ad1e19502103d, 0x9675e6ffb3cbe811, 0x18cce4daf2206982, 0xa9c29b109a6cea1f}, 1, true}},
    {0x1.1f3e8ad708f5bp+57, -0x1.222cab547385bp+33, 0x1.09941946801c6p-2, 0, {{0x0, 0x0, 0x0, 0xff1d000000000000, 0x83afcde65fdf35cb, 0xa2cb7c227eff133e}, 91, true}},
    {0x1.1f3e8ad708f5bp+57, -0x1.222cab547385bp+33, 0x1.09941946801c6p-2, 1, {{0x11cb57778311c238, 0xd75ae2e0d9bcc419, 0x81ecca600266cda7, 0xe114c13de3017ce2, 0x5db7a1c77aa8cce1, 0xfd6a379989e847ad}, 24, true}},
    {0x1.1f3e8ad708f5bp+57, -0x1.222cab547385bp+33, 0x1.09941946801c6p-2, 2, {{0x53a1b3cbdbea4e80, 0xd28f4577b4bd3cba, 0xa2abb5e2e3a7b666, 0x4d97d94a1e8a8353, 0x785e676edfc5027e, 0x825f65309b862dc0}, 0, false}},
    {0x1.1f3e8ad708f5bp+57, -0x1.222cab547385bp+33, 0x1.09941946801c6p-2, 3, {{0xa5c91f26950491fc, 0xae489b5aa5602697, 0x876c7acc9b62890, 0x620c1eceeb082c56, 0x3fc755948936fcc3, 0xde2ff713f6bfefc6}, 0, false}},
    {-0x1.3cb3c1ab10ea2p+32, 0x1.2a1fcf2f13768p+46, 0x1.e7c922b2d54e4p-2, 0, {{0x0, 0x0, 0x0, 0xe000000000000000, 0x1165567b56a69558, 0xb8684cc2960ab3a2}, 79, true}},
    {-0x1.3cb3c1ab10ea2p+32, 0x1.2a1fcf2f13768p+46, 0x1.e7c922b2d54e4p-2, 1, {{0x88fd8a1eb85a6a4b, 0x10423aa8874ddc1a, 0x5f5a89ab64a504c3, 0xbd45574710d6177c, 0xb30e3079f83f1f69, 0x87f9f8b65dab0aa6}, -13, true}},
    {-0x1.3cb3c1ab10ea2p+32, 0x1.2a1fcf2f13768p+46, 0x1.e7c922b2d54e4p-2, 2, {{0xfbddd38129db2f90, 0x3a2d1c6f1e5cc13, 0x7c485c239266066b, 0x553faa2c540d8039, 0xfa8f2a0efafa96d5, 0xb0afdcfdb13eb486}, 0, false}},
    {-0x1.3cb3c1ab10ea2p+32, 0x1.2a1fcf2f13768p+46, 0x1.e7c922b2d54e4p-2, 3, {{0x688b5a6a53b66dca, 0xc506ffc2c6aabc50, 0x6c1eded40252e959, 0x3655df6576d59389, 0x58f34687f876c67f, 0xaa196bcf916cc637}, 1, true}},
    {0x1.877127f968559p-39, -0x1.794946cb05445p-38, 0x1.bc706f3b40e36p-1, 0, {{0x0, 0x0, 0x0, 0x7897a7fbe6d81800, 0xffedf8d284ef7c25, 0xde38379da071afff}, 0, false}},
    {0x1.877127f968559p-39, -0x1.794946cb05445p-38, 0x1.bc706f3b40e36p-1, 1, {{0xb69ec60a0347b1a4, 0x5b97a005f44733b6, 0x1a9afa515688a1f5, 0x8d5a87c5c4d5fef4, 0x38f24dc1370739b8, 0x84cd749353f2df24}, 0, true}},
    {0x1.877127f968559p-39, -0x1.794946cb05445p-38, 0x1.bc706f3b40e36p-1, 2, {{0xaabb6a1dabc95d6e, 0x12e532b04b2c8eab, 0x40a2413b41f8d10b, 0xd2027896845dda12, 0x6ffa95b5650e7d7, 0xee8333d4ba36234c}, 0, false}},
    {0x1.877127f968559p-39, -0x1.794946cb05445p-38, 0x1.bc706f3b40e36p-1, 3, {{0x6faec35729b4bf0b, 0xcd9bd335ed839daa, 0xa9f736f1c920105a, 0x98c60d8c8ac01305, 0x42aefffba4d78b66, 0xfdbd4dd8d639ca3a}, 2, true}},
    {0x1.183e5f0906814p-71, 0x1.3c32c7d5d3309p-55, 0x1.467379c21b608p-3, 0, {{0x0, 0x0, 0x9cd13a4b40000000, 0xa24944042c07878b, 0x15, 0xa339bce10db04000}, -2, false}},
    {0x1.183e5f0906814p-71, 0x1.3c32c7d5d3309p-55, 0x1.467379c21b608p-3, 1, {{0xa973f1aefaae34df, 0x7978294b7abb6ccb, 0xfeff2c8d565ae411, 0xd193b878786b28fd, 0x7f4f26576c40b291, 0xe2e3f0ef346365fc}, -16, false}},
    {0x1.183e5f0906814p-71, 0x1.3c32c7d5d3309p-55, 0x1.467379c21b608p-3, 2, {{0x880e240020e1bfe8, 0x89311584c20638b6, 0x114ab3570a3fd34a, 0x8ec7f277ba367f1a, 0x818b3e161fb9a32a, 0xcc6a64ceb1756f33}, -1, false}},
    {0x1.183e5f0906814p-71, 0x1.3c32c7d5d3309p-55, 0x1.467379c21b608p-3, 3, {{0x1dfaba7c94bf178, 0x28a91b049e3caed3, 0x1561234a24260ce7, 0x673f0d868023df17, 0xa6201c825ab7c7d, 0x88247aa7f65f16c4}, 1, true}},
    {0x1.0e0f00bbcc2c6p-60, -0x1.776510237de04p-65, 0x1.a5ab08b764cc5p-1, 0, {{0x0, 0x0, 0xc5dcda0740000000, 0x9feb47d9e785bb72, 0xfffffffffffffff3, 0xd2d5845bb26627ff}, 0, false}},
    {0x1.0e0f00bbcc2c6p-60, -0x1.776510237de04p-65, 0x1.a5ab08b764cc5p-1, 1, {{0x74b8dd049fddf9d1, 0x690443f413fc698f, 0x895f4b4ce8d1b357, 0xcd33c2de220ccf54, 0xd5a201a849939dd1, 0xb82a876735ac219f}, 5, true}},
    {0x1.0e0f00bbcc2c6p-60, -0x1.776510237de04p-65, 0x1.a5ab08b764cc5p-1, 2, {{0xb5e9c300262a1437, 0xfd3b4fb76867c827, 0x918a9b80806198d9, 0x9571fff15f1728aa, 0x4c6126eadc045c28, 0xe8526f585fa50948}, 0, false}},
    {0x1.0e0f00bbcc2c6p-60, -0x1.776510237de04p-65, 0x1.a5ab08b764cc5p-1, 3, {{0xeaa8025a77c40123, 0x144fb90d0935e3aa, 0x86d67450279c4dae, 0x3f25352c9b29b967, 0x5e0fba603719c00b, 0xafd59e39edfd0490}, -1, false}},
    {-0x1.9992567301d7cp+58, 0x1.1187a7dc0643bp+12, 0x1.6da2613270601p-1, 0, {{0x0, 0x0, 0x0, 0x0, 0xbf30ab3c978f9ff0, 0xdacf0b755ae50b3b}, 71, true}},
    {-0x1.9992567301d7cp+58, 0x1.1187a7dc0643bp+12, 0x1.6da2613270601p-1, 1, {{0x5970829b4cbe4ee2, 0xeb528cf9de185534, 0x17a88b46f2c3db2e, 0xeae1b3ea317dd34d, 0x7b10f0ff0e5bf4fd, 0xbfa95c1f9d76875d}, 47, true}},
    {-0x1.9992567301d7cp+58, 0x1.1187a7dc0643bp+12, 0x1.6da2613270601p-1, 2, {{0x38da73c90bb9486e, 0xc0a4c0f826c9fc56, 0xc89ad43faf5e6909, 0xb9b5d095ba64a780, 0x9312e2f8770f766a, 0xd855f8ba22ea79a9}, 0, false}},
    {-0x1.9992567301d7cp+58, 0x1.1187a7dc0643bp+12, 0x1.6da2613270601p-1, 3, {{0x291dba007fc4321, 0x11a0b65661d990ec, 0x835882639c963488, 0xc403c0741e574a63, 0x8c4c5efe9d2fc274, 0xcb0433d40378617b}, -1, false}},
    {0x1.48fbbbc7c15f4p+16, 0x1.0359657c1be1fp+52, 0x1.c74abdfb676c8p-2, 0, {{0x0, 0x0, 0x0, 0x0, 0xd0c0b85c3cced900, 0xa6a4c87517f7a131}, 69, false}},
    {0x1.48fbbbc7c15f4p+16, 0x1.0359657c1be1fp+52, 0x1.c74abdfb676c8p-2, 1, {{0x6da60cc0b47123a2, 0x3afa5041e5f8ceab, 0xbceac5d6112fb090, 0xe4d5a33360506280, 0xd3357ec44d0dd6ca, 0xa25e10a063f27b7b}, -35, false}},
    {0x1.48fbbbc7c15f4p+16, 0x1.0359657c1be1fp+52, 0x1.c74abdfb676c8p-2, 2, {{0xd79df3ce7c6f13bd, 0x8a99845916103efb, 0xbc3b711734c19161, 0x601391e55f11f90b, 0x4a3f0bebf42c55c6, 0xaab358bbf72573ba}, 0, false}},
    {0x1.48fbbbc7c15f4p+16, 0x1.0359657c1be1fp+52, 0x1.c74abdfb676c8p-2, 3, {{0x4b02afe025e12502, 0x4256971cb7b944a8, 0x90a7024749167b44, 0xb8f3b12a10fbe3c, 0x7d5ff80907723dfc, 0xa5f2d3276471870b}, 1, true}},
    {0x1.b3963364c4c57p+9, -0x1.c539e54e33be6p-41, 0x1.fac2b79bc63a6p-2, 0, {{0x0, 0x0, 0x0, 0xac00000000000000, 0xa52e5623e6c96cb9, 0xfd615bc7dcc698e5}, -1, false}},
    {0x1.b3963364c4c57p+9, -0x1.c539e54e33be6p-41, 0x1.fac2b79bc63a6p-2, 1, {{0xe6bb05f420d4ff0b, 0x99a960294af157a, 0xe7bc4a00c1d2077b, 0xe2333940519f891b, 0xac8588da27cbcf1b, 0xf6095b827766884a}, 50, true}},
    {0x1.b3963364c4c57p+9, -0x1.c539e54e33be6p-41, 0x1.fac2b79bc63a6p-2, 2, {{0xaaa66d628cbbf9d9, 0x3a5a3dbefffa0c15, 0xbd8c97272f2c7da, 0xefa72c0d10564b9c, 0xdb26fd1345ed9db7, 0xb4173b962c96c473}, 0, false}},
    {0x1.b3963364c4c57p+9, -0x1.c539e54e33be6p-41, 0x1.fac2b79bc63a6p-2, 3, {{0xfa0166ee011eba3c, 0xff2d5dd3ef12943f, 0xd0c0762ae5bac786, 0x15e919859db792b1, 0xb7054db4197abfe9, 0xa6e0465cf4bd74df}, 0, false}},
    {-0x1.276eddf3e56ebp+22, 0x1.c911954d2337ap-5, 0x1.af418e40ed568p-2, 0, {{0x0, 0x0, 0x0, 0x0, 0xe84df30f3f800000, 0x83de3fbe5f0a31e4}, 19, true}},
    {-0x1.276eddf3e56ebp+22, 0x1.c911954d2337ap-5, 0x1.af418e40ed568p-2, 1, {{0x519b27e95658dca2, 0x5089239731d64273, 0x6e5569653c3136a2, 0xd89b2cd5d813e973, 0x617065f337d2926b, 0xa5782898983c9831}, 27, true}},
    {-0x1.276eddf3e56ebp+22, 0x1.c911954d2337ap-5, 0x1.af418e40ed568p-2, 2, {{0x7519ac74d113f6eb, 0x85ff91cb46702ee7, 0x1b99eb971794747d, 0x3bfcee73094d7799, 0xdbcca3969a81caf, 0xa62236bd69e1f61a}, 0, false}},
    {-0x1.276eddf3e56ebp+22, 0x1.c911954d2337ap-5, 0x1.af418e40ed568p-2, 3, {{0xc9af1e0076975ae3, 0x9ace634da8343133, 0xb5ddb975c4f357ff, 0xc1dfb5aa46367ecd, 0x9bcda6b2dbfee500, 0xba08771889d81a2b}, 0, false}},
    {0x1.7b1e9d98fd301p+52, -0x1.a7bce57d45a35p+54, 0x1.a15b914ac8c34p-2, 0, {{0x0, 0x0, 0x0, 0xbad4dcf300000000, 0x612bb2424d397a91, 0x9ce1d52fdbb090d7}, 108, true}},
    {0x1.7b1e9d98fd301p+52, -0x1.a7bce57d45a35p+54, 0x1.a15b914ac8c34p-2, 1, {{0xb3da44792637c11b, 0x81a7999e13b5049b, 0x1f1cc66ca899307a, 0x34d423f03ea3eb6e, 0xadfbe8205c915759, 0xe50b432db129d69f}, -2, true}},
    {0x1.7b1e9d98fd301p+52, -0x1.a7bce57d45a35p+54, 0x1.a15b914ac8c34p-2, 2, {{0xe52722f447120968, 0xc65b4536a06dc854, 0x2407cbc7dd11230a, 0x250b622643cf5fe8, 0x498cdcaf613c35fd, 0xa36f46a39f429a5c}, 0, false}},
    {0x1.7b1e9d98fd301p+52, -0x1.a7bce57d45a35p+54, 0x1.a15b914ac8c34p-2, 3, {{0xc745c766ae5b666d, 0xfd6f97fb1468779, 0x803fa800f48b2b35, 0x5ebd1a7b08464fd, 0xdd8be6d7121232b9, 0xeb10ad2f2a8fad78}, 1, true}},
    {-0x1.568b996f53e56p+2, 0x1.57c12956673d4p-65, 0x1.b67a2291e65edp-1, 0, {{0x0, 0x0, 0x0, 0xe7db477d90000000, 0x6810fdba6219d9f4, 0xdb3d1148f32f67fc}, 0, false}},
    {-0x1.568b996f53e56p+2, 0x1.57c12956673d4p-65, 0x1.b67a2291e65edp-1, 1, {{0x35f8daa080b11a45, 0xb4f7f5a2e4c63c7a, 0x4c7ba31fc3891241, 0x380d03bd87047140, 0x1043231d467944dc, 0xff1976b45ce79644}, 67, true}},
    {-0x1.568b996f53e56p+2, 0x1.57c12956673d4p-65, 0x1.b67a2291e65edp-1, 2, {{0xe92db7b198160b6d, 0xc164692c68646db4, 0x3e75d11c2a07cbf3, 0x152e4520b4161b29, 0x7d6eaf70a304ef76, 0xece844a2f81507c7}, 0, false}},
    {-0x1.568b996f53e56p+2, 0x1.57c12956673d4p-65, 0x1.b67a2291e65edp-1, 3, {{0x8ad8386aae52c632, 0x17a1d1823ecb2a28, 0xda19fb8e709b1c3b, 0x3265609b664554a2, 0xaaac71f1c27aa852, 0xd47327c53009b3f3}, -2, false}},
};
// clang-format on

W computed(const Case& x) {
    const W a = x.a, b = x.b, c = x.c;
    switch (x.what) {
        case 0:
            return a * b + c;
        case 1:
            return a * inverse(b);
        case 2:
            return c * inverse_root(c);
        default:
            return (a - b) * inverse(a + b) - c * inverse_root(c) * c;
    }
}

void results_are_those_of_flint() {
    for (const Case& x : CASES) {
        W expected;
        for (int i = 0; i < 6; ++i) expected.m[i] = x.result.m[i];
        expected.exponent = x.result.exponent, expected.negative = x.result.negative;
        const W got = computed(x), off = got - expected;
        HOLDS(std::abs(off.leading()) <= 8.0 * WIDE_UNIT<6> * std::max(std::abs(expected.leading()), std::abs(x.a * x.b)));
        HOLDS(near(got.leading(), expected.leading(), 2e-16 * std::abs(got.leading())));
    }
}

void doubles_are_kept() {
    for (int k = -300; k <= 300; ++k) {
        const double x = (k % 2 ? -1.0 : 1.0) * std::ldexp(1.0 + 0.3 * std::sin(double(k)), k);
        HOLDS(W(x).leading() == x);
        HOLDS((W(x) - W(x)).is_zero());
        HOLDS((W(x) + W(0.0)).leading() == x);
    }
    HOLDS(W(0.0).is_zero());
    HOLDS(W(5e-324).is_zero());
}

void sums_keep_what_cancels() {
    // (1 + e)^2 - 1 - 2 e = e^2 for e far below the rounding of one.
    for (int k = 60; k <= 190; ++k) {
        const W e = W(1.0).times_power(-k), x = W(1.0) + e;
        HOLDS((x * x - W(1.0) - W(2.0) * e).leading() == std::ldexp(1.0, -2 * k));
    }
}

void complex_numbers_are_a_field() {
    for (int k = 1; k <= 100; ++k) {
        const WideComplex<6> a = {std::sin(double(k)), std::cos(3.0 * k)}, one = a * inverse(a);
        HOLDS(std::abs((one.re - W(1.0)).leading()) < 64.0 * WIDE_UNIT<6>);
        HOLDS(std::abs(one.im.leading()) < 64.0 * WIDE_UNIT<6>);
    }
}

}  // namespace

void test_wide() {
    results_are_those_of_flint();
    doubles_are_kept();
    sums_keep_what_cancels();
    complex_numbers_are_a_field();
}

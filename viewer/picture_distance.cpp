#include "picture_distance.h"

#include "picture_files.h"
#include "study/flip.h"

namespace fumarole::command {

Display display_for(const std::string& target, const Image& image, std::optional<float> exposure)
{
    return {.exposure_ev = exposure_of(target, image, exposure),
            .transform =
                target == "transmittance" ? Display::Transform::srgb : Display::Transform::filmic};
}

PictureDistance picture_distance(const std::string& target, const Image& test,
                                 const Image& reference, std::optional<float> exposure)
{
    PictureDistance distance{.metrics = study::compare(test.pixels, reference.pixels),
                             .display = display_for(target, reference, exposure)};
    if (distance.metrics.finite)
        distance.flip = study::flip_of_radiance(test.pixels, reference.pixels, test.width,
                                                test.height, distance.display)
                            .mean;
    return distance;
}

}  // namespace fumarole::command

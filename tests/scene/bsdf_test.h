// Scenes of one material, and pictures for its textures.
#pragma once
#include <OpenImageIO/imageio.h>

#include <bit>

#include "scene_test.h"

namespace irradia::test {

class BsdfTest : public SceneTest {
protected:
    /// The scene of a rectangle with this bsdf, whose material begins on line 3.
    Scene with_bsdf(const std::string& bsdf, const LoadOptions& options = {}) {
        return load(sensor + lamp + "<shape type=\"rectangle\">\n" + bsdf + "</shape>", options);
    }
    /// Its material; scene_ and index_ are set.
    shared::Material material(const std::string& bsdf) {
        scene_ = with_bsdf(bsdf);
        index_ = static_cast<int>(scene_.triangles.at(2).material);
        return scene_.materials.at(scene_.triangles.at(2).material);
    }
    template <class T>
    void write_picture(const std::string& name, int width, int height, int channels, OIIO::TypeDesc type,
                       const std::vector<T>& data) {
        auto out = OIIO::ImageOutput::create(path(name));
        ASSERT_TRUE(out);
        ASSERT_TRUE(out->open(path(name), OIIO::ImageSpec(width, height, channels, type)));
        ASSERT_TRUE(out->write_image(type, data.data()));
        out->close();
    }
    Scene scene_;
    int index_ = 0;
};

}  // namespace irradia::test

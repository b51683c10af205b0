//! Which files are written for each frame.

use super::ground::Ground;
use super::image::Image;
use crate::base::settings::Complaint;
use crate::{choice, settings};

choice! {
    /// The form of the glTF file.
    pub enum Gltf {
        /// A node for each leaf.
        Nodes = "nodes",
        /// All leaves that share a texture in one mesh.
        Merged = "merged",
        /// `EXT_mesh_gpu_instancing`.
        Instanced = "instanced",
    }
}

choice! {
    /// The form of the chart of shares.
    pub enum Chart {
        /// A drawing with text, for papers and the web.
        Svg = "svg",
        /// A picture.
        Png = "png",
    }
}

settings! {
    /// What is written.
    pub struct Output {
        /// A picture of each frame.
        png: bool = true;
        /// A glTF file of each frame; none when absent.
        gltf: Option<Gltf> = None;
        /// A chart of the shares of the leaf states against time, with temperature and humidity under it: NAME.shares.svg or .png, once
        /// for all frames; none when absent.
        shares: Option<Chart> = None;
        /// Pictures of what most samples of each pixel show, beside each frame: NAME.depth.png (16 bits: millimetres along the
        /// viewing axis, 65535 for more and for the sky), NAME.normal.png (world axes x, y, z: 128 + 127 times each), NAME.leaf.png
        /// (red, green, blue as one number: 1 for the first leaf of the file of states; 0 for no leaf) and NAME.state.png (1 for
        /// the first state of that file's order of states; 0 for no leaf). A contact sheet has none.
        layers: bool = false;
        /// Bits of each channel of the picture, 8 or 16. With 16 a picture has no inset and is no contact sheet.
        bits: u32 = 8, range 8 => 16;
        /// The light of each pixel, exposed and before the tone curve, beside each picture: NAME.exr, linear sRGB in 32-bit floating
        /// point numbers, colours multiplied by alpha. A contact sheet has none. Needs a program that was built with `--features exr`.
        exr: bool = false;
        /// The shadow on level ground as a layer of its own, NAME.shadow.png: black, with the share of its light that the ground loses as
        /// alpha, to be laid under a picture with `image.background = "transparent"`. A contact sheet has none.
        ground_shadow: bool = false;
        /// One leaf enlarged in the lower right corner.
        inset: bool = false;
    }
}

/// What is wrong with well-typed outputs of a picture.
pub fn check(output: &Output, image: &Image, ground: &Ground) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    if ![8, 16].contains(&output.bits) {
        complaints.push(Complaint::new("bits", format!("{} bits have no PNG", output.bits), "write 8 or 16"));
    }
    if output.bits == 16 && output.inset {
        complaints.push(Complaint::new(
            "inset",
            "an inset is let into pictures of 8 bits only",
            "write output.bits = 8",
        ));
    }
    if output.bits == 16 && !image.label.is_empty() {
        let help = "write output.bits = 8, or take image.label away";
        complaints.push(Complaint::new("bits", "a label is written into pictures of 8 bits only", help));
    }
    if output.ground_shadow && !ground.heights.is_empty() {
        let help = "take one of the two away";
        complaints.push(Complaint::new(
            "ground_shadow",
            "the shadow's layer is for level ground, here are ground.heights",
            help,
        ));
    }
    if output.exr && !cfg!(feature = "exr") {
        let help = "build it with `--features exr`, or take the key away";
        complaints.push(Complaint::new("exr", "this program was built without OpenEXR", help));
    }
    complaints
}

//! One frame: composed, drawn, and turned into files that are not yet written.

use super::{CellFalls, CellStates, Run};
use crate::base::diagnostic::Diagnostics;
use crate::base::figures::Figures;
use crate::base::picture::Picture;
use crate::compose::contact_sheet::Sheet;
use crate::compose::{Stock, picture_inset};
use crate::export::{self, ExportError};
use crate::frame::Frame;
use crate::plan;
use crate::plot;
use crate::raster::{self, Drawing, Renderer, Wanted};
use crate::report::{Report, ViewReport};
use crate::run::finishing::{FrameFiles, Image, Made};
use crate::run::layers::{self, Seen};
use crate::run::preparation::Prepared;
use crate::run::stopwatch::{self, timed};
use crate::run::{enlargement, fault};
use crate::scene::camera::Subject;
use crate::scene::output::Gltf;
use std::time::Instant;

impl Run<'_> {
    /// The picture and the files of a frame; none when nothing is drawn. A cell without a stock in `stocks` gets one for the time being.
    pub(super) fn made(
        &mut self,
        index: i64,
        stocks: &[Option<Stock>],
        (states, falls): (&CellStates, &CellFalls),
        view: &mut Option<ViewReport>,
    ) -> Result<Made, Diagnostics> {
        let mut pictures = Vec::new();
        let mut deep = None;
        let mut files = Vec::new();
        let mut layers = Vec::new();
        for (number, (states, falls)) in states.iter().zip(falls).enumerate() {
            let of_its_own = if number < stocks.len() { None } else { self.stock(number)? };
            let Some(stock) = stocks.get(number).and_then(Option::as_ref).or(of_its_own.as_ref()) else { continue };
            let Prepared { scene, stand, plan, ways, .. } = &self.cells[number];
            let layout = scene.output.gltf;
            let worn = states.as_ref().map_or_else(Vec::new, |states| plan::garments(scene, stand, states));
            let frame = timed(&mut self.report, "compose", || {
                let trees = stock.frame(scene, stand, &worn);
                let leaf = (scene.camera.subject == Subject::Leaf).then(|| stock.specimen(scene, &worn, &trees));
                let mut frame = leaf.flatten().unwrap_or(trees);
                stock.aim(scene, stand, index, &mut frame);
                let instances = frame.instances.len() as u64;
                Ok::<_, Diagnostics>((frame, Figures::of(instances)))
            })?;
            let frame = match falls {
                Some(falls) if plan.has("fall") => {
                    let strewn = || {
                        let (frame, figures) = stock.strewn(scene, stand, falls, frame);
                        Ok::<_, Diagnostics>((frame, figures.with("ways", ways.found)))
                    };
                    timed(&mut self.report, "fall", strewn)?
                }
                _ => frame,
            };
            *view = (self.cells.len() == 1).then(|| view_of(&frame));
            // One thread writes the glTF file while the others draw.
            let name = self.names.gltf(index);
            let output = &self.scene.output;
            let wanted = Wanted {
                sites: !self.names.layers(index).is_empty(),
                radiance: output.bits == 16 || output.exr,
                ground_shadow: self.names.ground_shadow(index).is_some(),
                is_last: self.is_last(index),
            };
            let (drawing, glb) = rayon::join(
                || {
                    scene.output.png.then(|| {
                        let inset = self.scene.output.inset.then(|| stock.inset(&worn, &frame)).flatten();
                        let tools = (&mut self.report, &mut self.renderer);
                        rasterised(tools, &frame, (self.enlarged, inset.as_ref()), wanted)
                    })
                },
                || {
                    let start = Instant::now();
                    let glb = name.zip(layout).map(|(name, layout)| (name, export::glb(&frame, layout_of(layout))));
                    glb.map(|(name, glb)| (name, glb, start.elapsed().as_secs_f64()))
                },
            );
            if let Some(mut drawing) = drawing.transpose()? {
                if !scene.image.label.is_empty() {
                    plot::label(&mut drawing.picture, &scene.image.label);
                }
                if wanted.sites {
                    let seen = Seen { frame: &frame, sites: &drawing.sites, stand, states: states.as_ref() };
                    layers.extend(timed(&mut self.report, "png", || {
                        let made = layers::layers(&seen).map_err(|error| fault::export(&error))?;
                        Ok::<_, Diagnostics>((made, Figures::of(0)))
                    })?);
                }
                files.extend(self.beside(index, &frame, &drawing).map_err(|error| fault::export(&error))?);
                if self.scene.output.bits == 16 {
                    let size = [frame.view.width, frame.view.height];
                    deep = Some(Image::Sixteen { size, pixels: raster::developed(&frame, &drawing.radiance) });
                }
                pictures.push((self.scene.seeds.get(number).copied(), drawing.picture));
            }
            if let Some((name, glb, seconds)) = glb {
                let (bytes, figures) = glb.map_err(|error| fault::export(&error))?;
                self.report.add("gltf", seconds, figures);
                files.push((name, bytes));
            }
        }
        files.extend(self.names.layers(index).into_iter().zip(layers));
        let name = self.names.png(index).filter(|_| !pictures.is_empty());
        let picture = name.map(|name| (name, deep.unwrap_or_else(|| Image::Eight(self.assembled(pictures)))));
        Ok(Made { picture, files })
    }

    /// Whether what is drawn of a frame serves no other: it is the last, or one of many cells, which are unlike.
    fn is_last(&self, index: i64) -> bool {
        let drawn =
            |cell: &Prepared| cell.plan.frames.iter().rfind(|frame| frame.same_as.is_none()).map(|frame| frame.index);
        self.cells.len() > 1 || self.cells.first().and_then(drawn) == Some(index)
    }

    /// The files of a frame's light and of its shadow on the ground.
    fn beside(&self, index: i64, frame: &Frame, drawing: &Drawing) -> Result<FrameFiles, ExportError> {
        let (width, height) = (frame.view.width, frame.view.height);
        let mut files = Vec::new();
        if let Some(name) = self.names.exr(index) {
            files.push((name, export::exr(width, height, &drawing.radiance)?));
        }
        if let Some(name) = self.names.ground_shadow(index) {
            let pixels = drawing.ground_shadow.iter().map(|&alpha| [0, 0, 0, alpha]).collect();
            files.push((name, export::png(&Picture { width, height, pixels })?));
        }
        Ok(files)
    }

    /// The picture of a frame: the only one, or all of them as a contact sheet.
    fn assembled(&self, mut pictures: Vec<(Option<u64>, Picture)>) -> Picture {
        match pictures.pop() {
            Some((_, picture)) if self.scene.cell_count() == 0 => picture,
            last => {
                pictures.extend(last);
                let image = &self.scene.image;
                Sheet::in_columns(image.width, image.height, pictures.len(), image.columns).assemble(&pictures)
            }
        }
    }
}

/// A frame drawn, with another let into its picture.
fn rasterised(
    (report, renderer): (&mut Report, &mut Renderer),
    frame: &Frame,
    (enlarged, inset): (u32, Option<&Frame>),
    wanted: Wanted,
) -> Result<Drawing, Diagnostics> {
    timed(report, "raster", || {
        let before = stopwatch::processor_seconds();
        let mut drawing = enlargement::drawn(renderer, frame, enlarged, wanted);
        if let Some(inset) = inset {
            picture_inset::place(&mut drawing.picture, &renderer.draw_apart(inset, Wanted::default()).picture);
        }
        let figures = std::mem::take(&mut drawing.figures);
        Ok((drawing, figures.with("cpu_seconds", stopwatch::processor_seconds() - before)))
    })
}

fn view_of(frame: &Frame) -> ViewReport {
    ViewReport {
        position: frame.camera.position.into(),
        target: frame.camera.target.into(),
        field_of_view: frame.camera.field_of_view.to_degrees(),
        sun: frame.sun.direction.into(),
        sun_irradiance: frame.sun.irradiance,
        exposure: frame.view.exposure,
    }
}

fn layout_of(layout: Gltf) -> export::Layout {
    match layout {
        Gltf::Nodes => export::Layout::Nodes,
        Gltf::Merged => export::Layout::Merged,
        Gltf::Instanced => export::Layout::Instanced,
    }
}
